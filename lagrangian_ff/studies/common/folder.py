"""A study's folder: which study it is, its lines one by one, its numbers and its picture."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lagrangian_ff.errors import UserError
from lagrangian_ff.studies.common.case import Line


@dataclass(frozen=True)
class Folder:
    """Paths of everything a study leaves behind.

    Attributes:
        root: the folder.
        name: the study's.
    """

    root: Path
    name: str

    @property
    def lines(self) -> Path:
        """One JSON object a line, one line a case, in the order in which they were done."""
        return self.root / "cases.jsonl"

    @property
    def what(self) -> Path:
        """Which study this is."""
        return self.root / "study.json"

    @property
    def summary(self) -> Path:
        """The numbers of the table."""
        return self.root / "summary.json"

    @property
    def picture(self) -> Path:
        """The figure."""
        return self.root / f"{self.name}.png"

    def prepare(self, identity: Mapping[str, Any]) -> None:
        """Make the folder, or see that what is in it is the same study.

        Args:
            identity: see `Study.identity`.

        Raises:
            UserError: it holds another study, or cannot be made. Nothing is overwritten.
        """
        try:
            self.root.mkdir(parents=True, exist_ok=True)
            if self.what.is_file():
                held = json.loads(self.what.read_text(encoding="utf-8"))
                if held != dict(identity):
                    raise UserError(
                        f"{self.root}: holds another study ({_words(held)}), expected "
                        f"{_words(identity)}; go on with that one, or name another folder with "
                        "--output"
                    )
            elif self.lines.exists():
                raise UserError(
                    f"{self.root}: holds {self.lines.name} without {self.what.name}, so that "
                    "nobody knows of which study; name another folder with --output"
                )
            self.what.write_text(json.dumps(dict(identity)), encoding="utf-8")
        except OSError as error:
            raise UserError(f"{self.root}: cannot be written: {error.strerror}") from error
        except json.JSONDecodeError as error:
            raise UserError(f"{self.what}: not readable ({error}); remove it") from error

    def done(self) -> dict[str, Line]:
        """The lines so far by case, the last of each; a line cut off by an interruption is none."""
        found: dict[str, Line] = {}
        if self.lines.is_file():
            for text in self.lines.read_text(encoding="utf-8").splitlines():
                try:
                    line = json.loads(text)
                except json.JSONDecodeError:
                    continue
                found[line["case"]] = line
        return found

    def append(self, line: Line) -> Line:
        """Keep a line, on the disk when this returns; the line as it will be read again."""
        text = json.dumps(line, ensure_ascii=False)
        with self.lines.open("a+b") as file:
            if file.tell():
                file.seek(-1, os.SEEK_END)
                if file.read(1) != b"\n":
                    file.write(b"\n")
            file.write(text.encode() + b"\n")
            file.flush()
            os.fsync(file.fileno())
        kept: Line = json.loads(text)
        return kept


def _words(identity: object) -> str:
    if not isinstance(identity, Mapping):
        return str(identity)
    return ", ".join(f"{key} {value}" for key, value in identity.items())
