"""The entry point: the parser of the whole command line, and how every run of a command ends."""

import argparse
import io
import os
import shutil
import sys
from collections.abc import Sequence
from difflib import get_close_matches
from typing import Any, NoReturn

from lagrangian_ff import __version__
from lagrangian_ff.cli.commands import COMMANDS
from lagrangian_ff.cli.common.claims import release
from lagrangian_ff.cli.common.console import WIDEST, silence
from lagrangian_ff.errors import UserError

OK, USER_ERROR, INTERRUPTED = 0, 2, 130

DESCRIPTION = """\
Learn the inverse dynamics of a robot arm from recordings of its joint states, see where the model
fails and which physical effect it lacks, add it, and compute feedforward torque with the model."""

EPILOG = """\
a first session, without a robot and without ROS:
  lagrangian_ff simulate --output arm_bag        drive the simulated arm, record a bag
  lagrangian_ff info arm_bag                     what does the bag hold?
  lagrangian_ff identify arm_bag --train 1.0 --output model.npz
                                                 learn the model, see its error
  lagrangian_ff simulate --seed 1 --output before
  lagrangian_ff simulate --seed 1 --feedforward model.npz --output after
                                                 an unseen motion without and with its torque

what is missing in a model:
  lagrangian_ff compare model.npz before         where does it fail?
  lagrangian_ff diagnose model.npz arm_bag --confirm before
                                                 which physical effect is missing?
  lagrangian_ff add model.npz EFFECT --joint JOINT
  lagrangian_ff history NEW.npz                  what was added, why, and the fall of the error

Every command explains itself: lagrangian_ff COMMAND --help
Exit codes: 0 done, 2 a mistake you can fix (explained on stderr), 130 interrupted."""


class Layout(argparse.RawDescriptionHelpFormatter):
    """Descriptions as they are written, options as wide as the terminal, up to a limit."""

    def __init__(self, prog: str) -> None:
        width = min(WIDEST, shutil.get_terminal_size((WIDEST, 24)).columns)
        super().__init__(prog, max_help_position=30, width=width)


class Parser(argparse.ArgumentParser):
    """argparse with our layout of help, and errors that say where to read on."""

    def __init__(self, **how: Any) -> None:
        super().__init__(formatter_class=Layout, allow_abbrev=False, **how)

    def error(self, message: str) -> NoReturn:
        """Say what is wrong, how the command is used, and end with exit code 2."""
        self.print_usage(sys.stderr)
        print(f"error: {message}{self._swallowed(message)}", file=sys.stderr)
        print(f"read on: {self.prog} --help", file=sys.stderr)
        sys.exit(2)

    def _swallowed(self, message: str) -> str:
        """Return what may have happened to an argument that is missing."""
        greedy = [a.option_strings[0] for a in self._actions if a.nargs == "+" and a.option_strings]
        if not greedy or "arguments are required: " not in message:
            return ""
        missing = message.rpartition(": ")[2].split(", ")[0]
        if missing.startswith("-"):
            return ""
        return f"; put {missing} first: what follows {' or '.join(greedy)} is taken for its values"


class CommandParser(Parser):
    """The parser of one command, which answers for options that it does not have."""

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse, and refuse what is left over; argparse would leave that to the parser above."""
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}{self._meant(unknown)}")
        return found, unknown

    def _meant(self, unknown: Sequence[str]) -> str:
        """Return a question with the options whose names are near to those that do not exist."""
        options = [name for name in self._option_string_actions if name.startswith("--")]
        given = [one.partition("=")[0] for one in unknown if one.startswith("--")]
        near = [match for one in given for match in get_close_matches(one, options, 1)]
        return f"; is {', '.join(near)} meant?" if near else ""


def build_parser() -> Parser:
    """Return the parser; a parsed command has `run`, which takes the parsed arguments."""
    parser = Parser(prog="lagrangian_ff", description=DESCRIPTION, epilog=EPILOG)
    parser.add_argument("--version", action="version", version=f"lagrangian_ff {__version__}")
    subparsers = parser.add_subparsers(
        title="commands", metavar="COMMAND", required=True, parser_class=CommandParser
    )
    for command in COMMANDS:
        sub = subparsers.add_parser(
            command.NAME,
            help=command.SUMMARY,
            description=command.DESCRIPTION,
            usage=f"{parser.prog} {command.NAME} {command.USAGE}",
            epilog=command.EPILOG,
        )
        command.add_arguments(sub)
        sub.set_defaults(run=command.run)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        argv: the arguments; None takes those of the process.

    Returns:
        0 when done, 2 for a mistake that the user can mend, 130 after Ctrl-C. What argparse refuses
        ends the process with 2 as well.
    """
    # Else OpenBLAS' second thread spins after each piece of work and takes a processor
    # from what comes next. Read when NumPy is imported, which no module up to here does.
    os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", "4")
    _open_closed_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal that has no middle dot
    try:
        arguments = build_parser().parse_args(argv)
        code: int = arguments.run(arguments)
        sys.stdout.flush()
        return code
    except BrokenPipeError:  # at the last flush
        silence(sys.stdout)
        return OK
    except (UserError, OSError) as error:
        print(f"error: {_words(error)}", file=sys.stderr)
        return USER_ERROR
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    finally:
        release()


def _open_closed_streams() -> None:
    """Open standard streams that the caller closed, as `>&-` does, to nowhere.

    A file that is opened later would get the number of a closed one, and what libraries print.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # gets the lowest free number: this one
            if getattr(sys, name) is None:
                setattr(sys, name, os.fdopen(number, "r" if number == 0 else "w", closefd=False))


def _words(error: UserError | OSError) -> str:
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return str(error)
