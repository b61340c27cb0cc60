"""A whole study in its folder: done case by case, and continued where it was interrupted."""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lagrangian_ff.errors import UserError
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.studies.study import Line, Study
from lagrangian_ff.studies.workers import Workers, here


class Folder:
    """The paths of everything that a study leaves behind.

    Attributes:
        root: the folder.
        lines: one JSON object a line, one line a case, as they were done.
        identity, summary: the study's identity and the numbers of its table, as JSON.
        picture: the figure.
    """

    def __init__(self, root: Path, name: str) -> None:
        self.root, self.lines = root, root / "cases.jsonl"
        self.identity, self.summary = root / "study.json", root / "summary.json"
        self.picture = root / f"{name}.png"

    def prepare(self, identity: Mapping[str, Any]) -> None:
        """Make the folder, or check that it holds the same study.

        Args:
            identity: of the study, as `Study.identity` returns it.

        Raises:
            UserError: it holds another study, or cannot be made. Nothing is overwritten.
        """
        try:
            self.root.mkdir(parents=True, exist_ok=True)
            if self.identity.is_file():
                held = json.loads(self.identity.read_text(encoding="utf-8"))
                if held != dict(identity):
                    raise UserError(
                        f"{self.root}: holds another study ({_words(held)}), expected "
                        f"{_words(identity)}; go on with that one, or name another folder with "
                        "--output"
                    )
            elif self.lines.exists():
                raise UserError(
                    f"{self.root}: holds {self.lines.name} without {self.identity.name}, so that "
                    "its study is unknown; name another folder with --output"
                )
            self.identity.write_text(json.dumps(dict(identity)), encoding="utf-8")
        except OSError as error:
            raise UserError(f"{self.root}: cannot be written: {error.strerror}") from error
        except json.JSONDecodeError as error:
            raise UserError(f"{self.identity}: not readable ({error}); remove it") from error

    def done(self) -> dict[str, Line]:
        """Return the lines so far by case, the last of each, without one that was cut off."""
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
        """Write a line to the disk, and return it as it will be read again."""
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


def run(
    study: Study, output: Path, workers: Workers = here, progress: Progress = silent
) -> list[Line]:
    """Do the cases that are not done yet.

    Args:
        study: whose cases.
        output: the study's folder; an interrupted study goes on.
        workers: who does the cases.
        progress: receives the share of cases done, 0 to 1.

    Returns:
        The lines of all the cases asked for, in the study's order.

    Raises:
        UserError: the folder holds another study or cannot be written, no case matches, or there
            are no workers.
        KeyboardInterrupt: Ctrl-C. What was done is kept, and the same call goes on from there.
    """
    wanted = study.cases()
    folder = Folder(output, study.name)
    folder.prepare(study.identity())
    lines = {
        name: line
        for name, line in folder.done().items()
        if "failed" not in line and study.current(line)
    }
    todo = [case for case in wanted if case.name not in lines]
    count = len(wanted) - len(todo)
    progress(count / len(wanted), "cases")
    for line in workers(todo) if todo else ():
        lines[line["case"]] = folder.append(line)
        count += 1
        progress(count / len(wanted), f"{count} of {len(wanted)} cases, {line['case']}")
    return [lines[case.name] for case in wanted]


def record_all(
    study: Study, output: Path, workers: Workers = here, progress: Progress = silent
) -> list[str]:
    """Make and keep the recordings of all cases asked for, without judging them.

    Returns:
        In words what was made and what failed.

    Raises:
        UserError: as `run`, or the study makes no recordings.
    """
    recorders = study.recorders()
    Folder(output, study.name).prepare(study.identity())
    failed = []
    for count, line in enumerate(workers(recorders), start=1):
        progress(count / len(recorders), f"{count} of {len(recorders)} cases, {line['case']}")
        failed += [f"  {line['case']}: {line['failed']}"] if "failed" in line else []
    made = f"recorded: {len(recorders) - len(failed)} of {len(recorders)} cases, in {output}"
    return [made, *(["failed:", *failed] if failed else [])]
