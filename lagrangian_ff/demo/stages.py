"""The progress of the demo: a bar while a stage runs, a line when it is done."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from lagrangian_ff.progress import Progress as Report


class Stages:
    """Shows the stages of the demo one after the other.

    Attributes:
        seconds: of each stage, by name.
    """

    def __init__(self, console: Console) -> None:
        self._console = console
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str, doing: str) -> Iterator[Report]:
        """Show a stage while the block runs; yield the receiver of its progress.

        Args:
            name: for the record.
            doing: for people.
        """
        began = time.monotonic()
        quiet = not self._console.is_terminal
        doing_now, label = TextColumn("  {task.description}"), TextColumn("{task.fields[label]}")
        times = TimeElapsedColumn(), TimeRemainingColumn()
        columns = doing_now, BarColumn(bar_width=28), label, *times
        bar = Progress(*columns, console=self._console, transient=True, disable=quiet)
        if quiet:
            self._console.print(f"  … {doing}", highlight=False, soft_wrap=True)
        with bar:
            task = bar.add_task(doing, total=1.0, label="")

            def report(fraction: float, label: str) -> None:
                bar.update(task, completed=fraction, label=label)

            yield report
        took = time.monotonic() - began
        self.seconds[name] = self.seconds.get(name, 0.0) + took
        self._console.print(
            f"  [green]✓[/] {doing} [dim]{took:.1f} s[/]", highlight=False, soft_wrap=True
        )
