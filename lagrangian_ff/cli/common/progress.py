"""Progress of long work on standard error: a bar on a terminal, else a line at start and end."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from lagrangian_ff.progress import Progress

QUIET_SECONDS = 2.0
"""Work shorter than this is not mentioned in a log."""


@contextmanager
def progress_bar(title: str) -> Iterator[Progress]:
    """Show the progress of the work in the block, which reports it to what is yielded.

    Args:
        title: what is done, as in "identifying".
    """
    if sys.stderr.isatty():
        yield from _bar(title)
    else:
        yield from _lines(title)


def _bar(title: str) -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        SpinnerColumn,
        TaskProgressColumn,
        TextColumn,
        TimeElapsedColumn,
    )
    from rich.progress import Progress as Bars

    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
    )
    with Bars(*columns, console=Console(stderr=True), transient=True) as bars:
        task = bars.add_task(title, total=1.0)

        def report(fraction: float, label: str) -> None:
            bars.update(task, completed=fraction, description=f"{title}: {label}")

        yield report


def _lines(title: str) -> Iterator[Progress]:
    began = time.monotonic()
    told = False

    def report(fraction: float, label: str) -> None:
        nonlocal told
        if not told and time.monotonic() - began > QUIET_SECONDS:
            told = True
            print(f"{title} ...", file=sys.stderr, flush=True)

    yield report
    if told:
        print(f"{title}: {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
