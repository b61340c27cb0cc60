"""The study's folder: results line by line, and recordings that are kept."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lagrangian_ff.errors import UserError
from lagrangian_ff.recording import load, write_npz
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.studies.hidden.cases import Case
from lagrangian_ff.studies.hidden.plants import Stretches, record


@dataclass(frozen=True)
class Folder:
    """Paths of everything the study leaves behind.

    Attributes:
        root: the folder.
    """

    root: Path

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
        return self.root / "hidden.png"

    def prepare(self, what: Mapping[str, Any]) -> None:
        """Make the folder, or see that what is in it is the same study.

        Args:
            what: what makes two studies the same, such as the seed.

        Raises:
            UserError: it holds another study, or cannot be made.
        """
        try:
            self.root.mkdir(parents=True, exist_ok=True)
            if self.what.is_file():
                held = json.loads(self.what.read_text(encoding="utf-8"))
                if held != dict(what):
                    raise UserError(
                        f"{self.root}: holds another study ({_words(held)}), expected "
                        f"{_words(what)}; go on with that one, or name another folder with --output"
                    )
            self.what.write_text(json.dumps(dict(what)), encoding="utf-8")
        except OSError as error:
            raise UserError(f"{self.root}: cannot be written: {error.strerror}") from error
        except json.JSONDecodeError as error:
            raise UserError(f"{self.what}: not readable ({error}); remove it") from error

    def done(self) -> dict[str, dict[str, Any]]:
        """The lines so far by case, the last of each; a line cut off by an interruption is none."""
        found: dict[str, dict[str, Any]] = {}
        if self.lines.is_file():
            for text in self.lines.read_text(encoding="utf-8").splitlines():
                try:
                    line = json.loads(text)
                except json.JSONDecodeError:
                    continue
                found[line["case"]] = line
        return found

    def append(self, line: Mapping[str, Any]) -> dict[str, Any]:
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
        kept: dict[str, Any] = json.loads(text)
        return kept


def _words(what: Mapping[str, Any]) -> str:
    return ", ".join(f"{key} {value}" for key, value in what.items())


def recorded(
    case: Case, folder: Path, stretches: Stretches, *, keep: bool = False
) -> tuple[Recording, Recording, dict[str, Any]]:
    """The recordings of a case; with `keep` from the folder, or made and kept there."""
    place = folder / "recordings" / case.name
    paths, about = [place / f"{number}.npz" for number in (1, 2)], place / "info.json"
    if keep and about.is_file():
        first, second = (load(path) for path in paths)
        return first, second, json.loads(about.read_text(encoding="utf-8"))
    first, second, plant = record(case, folder, stretches)
    if keep:
        place.mkdir(parents=True, exist_ok=True)
        for path, each in zip(paths, (first, second), strict=True):
            write_npz(path, each)
        part = about.with_suffix(".part")
        part.write_text(json.dumps(plant, indent=1, ensure_ascii=False), encoding="utf-8")
        part.replace(about)
    return first, second, plant
