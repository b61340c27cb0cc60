"""Work in a process of its own, whose processor time and memory are its own too."""

import pickle
import resource
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

CODE = "from lagrangian_ff.studies.measured.alone import _serve; _serve()"
STATUS = Path("/proc/self/status")


def alone(work: Callable[..., Any], *arguments: object) -> Any:
    """Return what a function returns in a new process of one thread.

    Args:
        work: picklable, as are its arguments and what it returns.

    Raises:
        RuntimeError: the process was killed, as for want of memory.
        Exception: what the function raised.
    """
    asked = pickle.dumps(partial(work, *arguments))
    done = subprocess.run([sys.executable, "-c", CODE], input=asked, capture_output=True)
    if done.returncode != 0:
        last = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
        raise RuntimeError(f"the process ended with {done.returncode}: {' '.join(last)}")
    found, raised = pickle.loads(done.stdout)
    if raised is not None:
        raise raised
    return found


def peak_memory() -> float:
    """Return the most memory that this process has held, in GB."""
    try:
        # What getrusage says of a child begins with what its parent held when it was started.
        line = next(one for one in STATUS.read_text().splitlines() if one.startswith("VmHWM"))
        return float(line.split()[1]) * 1024 / 1e9
    except (OSError, StopIteration):
        most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return most * (1 if sys.platform == "darwin" else 1024) / 1e9


def _serve() -> None:
    """Do what standard input asks, and answer on standard output."""
    from lagrangian_ff.kernels import threads

    work = pickle.load(sys.stdin.buffer)
    found, raised = None, None
    with threads.limited(1), threads.one_blas_thread():
        try:
            found = work()
        except Exception as error:
            raised = error
    sys.stdout.buffer.write(pickle.dumps((found, raised)))
