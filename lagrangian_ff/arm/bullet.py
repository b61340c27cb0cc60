"""PyBullet, imported without the line that its C library prints."""

import contextlib
import os
import sys
from collections.abc import Iterator

from lagrangian_ff.errors import ArmError


@contextlib.contextmanager
def _without_standard_error() -> Iterator[None]:
    """Lose what is written to the standard error meanwhile, also by C code."""
    try:
        kept = os.dup(2)
    except OSError:  # it is closed
        yield
        return
    sys.stderr.flush()
    nothing = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nothing, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nothing)


with _without_standard_error():
    try:
        import pybullet
    except ModuleNotFoundError as error:
        raise ArmError("the simulated arm needs PyBullet: pip install pybullet") from error

__all__ = ["pybullet"]
