"""The entry point: which command is meant, and how every run of it ends."""

import io
import os
import sys
from collections.abc import Sequence

from lagrangian_ff.cli.parser import build_parser
from lagrangian_ff.errors import UserError

OK, USER_ERROR, INTERRUPTED = 0, 2, 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        argv: the arguments; None takes those of the process.

    Returns:
        0 when done, 2 for a mistake the user can mend, 130 after Ctrl-C. What argparse refuses
        ends the process with 2 as well.
    """
    # Else OpenBLAS' second thread goes on turning after each piece of work and takes a processor
    # from what comes next. Read when NumPy is imported, which no module up to here does.
    os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", "4")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal that has no middle dot
    try:
        arguments = build_parser().parse_args(argv)
        code: int = arguments.run(arguments)
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # The reader of a pipe (head, less) has left: not an error, but Python would complain at
        # exit when it flushes what is left.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return OK
    except (UserError, OSError) as error:
        print(f"error: {_words(error)}", file=sys.stderr)
        return USER_ERROR
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED


def _words(error: UserError | OSError) -> str:
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return str(error)
