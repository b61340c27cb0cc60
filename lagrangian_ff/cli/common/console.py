"""Text, tables and progress bars of a command."""

import os
import re
import shutil
import sys
import textwrap
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TextIO

from lagrangian_ff.progress import Progress

WIDEST = 100
COMMAND = re.compile(r"^  lagrangian_ff \S+(?: \S+)*", re.MULTILINE)
"""A command to type next, without what is said of it behind spaces."""
QUIET_SECONDS = 2.0
"""A log does not mention work that is shorter than this."""


class Console:
    """Prints text for people.

    Args:
        json: the value of --json; with "-" standard output belongs to the record, and the text
            goes to standard error.

    Attributes:
        option: that a command to type next needs, too, as --effects-file FILE; empty for none.
    """

    def __init__(self, json: str | None = None) -> None:
        self._stream = sys.stderr if json == "-" else sys.stdout
        self._width = min(WIDEST, shutil.get_terminal_size((WIDEST, 24)).columns)
        self._noted: set[str] = set()
        self.option = ""

    def say(self, lines: str | Iterable[str] = "") -> None:
        """Print lines as they are; a command to type next gets `option`, unless it has one such."""
        for line in [lines] if isinstance(lines, str) else lines:
            if self.option and self.option.split()[0] not in line:
                line = COMMAND.sub(lambda found: f"{found[0]} {self.option}", line)
            try:
                print(line, file=self._stream, flush=True)
            except BrokenPipeError:  # the reader (head, less) has left; the work goes on
                silence(self._stream)

    def paragraph(self, text: str, indent: str = "", hanging: str | None = None) -> None:
        """Print a text wrapped to the terminal; file names stay whole."""
        self.say(
            textwrap.wrap(
                text,
                width=self._width,
                initial_indent=indent,
                subsequent_indent=indent if hanging is None else hanging,
                break_long_words=False,
                break_on_hyphens=False,
            )
        )

    def bullet(self, text: str) -> None:
        """Print an item of a list."""
        self.paragraph(text, "  - ", "    ")

    def note(self, text: str, indent: str = "") -> None:
        """Print `note: ...`, unless the same was noted before."""
        if text not in self._noted:
            self._noted.add(text)
            self.paragraph(f"note: {text}", indent, f"{indent}      ")


def silence(stream: TextIO) -> None:
    """Let a stream whose reader has left lead nowhere, so that nothing complains at exit."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return indented columns two spaces apart; those that hold numbers are aligned right."""
    columns = list(zip(header, *rows, strict=True))
    widths = [max(map(len, column)) for column in columns]
    right = [_numeric(column[1:]) for column in columns]
    lines = []
    for row in [header, *rows]:
        cells = [
            cell.rjust(width) if to_right else cell.ljust(width)
            for cell, width, to_right in zip(row, widths, right, strict=True)
        ]
        lines.append("  ".join(["", *cells]).rstrip())
    return lines


def _numeric(cells: Sequence[str]) -> bool:
    return all(cell == "-" or cell.lstrip("-")[:1].isdigit() for cell in cells) and bool(cells)


@contextmanager
def progress_bar(title: str) -> Iterator[Progress]:
    """Show the progress of the work in the block, which reports it to what is yielded.

    It goes to standard error: a bar on a terminal, else a line at the start and one at the end. The
    title says what is done, as in "identifying".
    """
    if sys.stderr.isatty():
        yield from _bar(title)
    else:
        yield from _lines(title)


def _bar(title: str) -> Iterator[Progress]:
    from rich import console, progress

    columns = (
        progress.SpinnerColumn(),
        progress.TextColumn("{task.description}", markup=False),
        progress.BarColumn(),
        progress.TaskProgressColumn(),
        progress.TimeElapsedColumn(),
    )
    terminal = console.Console(stderr=True)
    with progress.Progress(*columns, console=terminal, transient=True) as bars:
        task = bars.add_task(title, total=1.0)

        def report(fraction: float, label: str) -> None:
            bars.update(task, completed=fraction, description=f"{title}: {label}")

        yield report


def _lines(title: str) -> Iterator[Progress]:
    began = time.monotonic()
    mentioned = False

    def report(fraction: float, label: str) -> None:
        nonlocal mentioned
        if not mentioned and time.monotonic() - began > QUIET_SECONDS:
            mentioned = True
            print(f"{title} ...", file=sys.stderr, flush=True)

    yield report
    if mentioned:
        print(f"{title}: {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
