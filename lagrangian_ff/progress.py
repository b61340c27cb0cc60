"""Long work reports what it has done to one callable that is handed down, never a global."""

from collections.abc import Callable

Progress = Callable[[float, str], None]
"""Receives the share done, 0 to 1, and what is being done now."""


def silent(fraction: float, label: str) -> None:
    """Report nothing."""


def part(progress: Progress, low: float, high: float) -> Progress:
    """Return the progress of a part of the work, which fills the whole from `low` to `high`."""
    return lambda share, label: progress(low + share * (high - low), label)
