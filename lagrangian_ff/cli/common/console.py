"""Where the text of a command goes, and notes that are shown once."""

import shutil
import sys
import textwrap
from collections.abc import Iterable

WIDEST = 100


class Console:
    """Prints text for people.

    Args:
        json: the value of --json; with "-" standard output belongs to the record, and the text
            goes to standard error.
    """

    def __init__(self, json: str | None = None) -> None:
        self._stream = sys.stderr if json == "-" else sys.stdout
        self._width = min(WIDEST, shutil.get_terminal_size((WIDEST, 24)).columns)
        self._noted: set[str] = set()

    def say(self, lines: str | Iterable[str] = "") -> None:
        """Print lines as they are."""
        for line in [lines] if isinstance(lines, str) else lines:
            print(line, file=self._stream, flush=True)

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

    def note(self, text: str, indent: str = "  ") -> None:
        """Print `note: ...`, unless the same was noted before."""
        if text not in self._noted:
            self._noted.add(text)
            self.paragraph(f"note: {text}", indent, f"{indent}      ")
