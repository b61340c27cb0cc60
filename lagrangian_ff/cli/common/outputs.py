"""Files that a command reads and writes: refused before any work, written whole or not at all."""

import os
import sys
from argparse import Namespace
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff import files
from lagrangian_ff.cli.common.claims import claim
from lagrangian_ff.cli.common.console import silence
from lagrangian_ff.errors import UserError
from lagrangian_ff.record_json import to_json

if TYPE_CHECKING:
    from lagrangian_ff.arrays import Floats


SUFFIXES = {
    "output": "", "save_trajectory": "", "picture": ".png", "plotjuggler": ".xml",
    "foxglove": ".json", "report": ".html", "formulas": ".json", "json": "",
}  # fmt: skip
"""The options that name a file to write, in the order of their checks, and how the file ends."""


def check_sources(sources: Iterable[Path]) -> None:
    """Raise UserError if a recording is not there."""
    for source in sources:
        if not source.exists():
            raise UserError(f"{source}: no such file or directory")


def check_outputs(
    arguments: Namespace, reads: Iterable[Path | None], suffix: str = "", *, folder: str = ""
) -> None:
    """Refuse files to write that are there, cannot be written, or are used for something else.

    Args:
        arguments: with --force and any of the options in `SUFFIXES`.
        reads: files that the command reads; None for those that were not given.
        suffix: the end of the name that --output gives.
        folder: one of `FOLDERS` if --output names a folder.

    Raises:
        UserError: one may not be written, and why.
    """
    keep = [path for path in reads if path is not None]
    for name, usual in SUFFIXES.items():
        given = getattr(arguments, name, None)
        if given is None or (name == "json" and given == "-"):
            continue
        path, option = Path(given), f"--{name.replace('_', '-')}"
        if folder and name == "output":
            check_folder(path, option, folder, force=arguments.force, keep=keep)
        else:
            end = suffix if name == "output" else usual
            check_file(path, option, force=arguments.force, suffix=end, keep=keep)
        keep.append(path)


def check_file(
    path: Path, option: str, *, force: bool, suffix: str = "", keep: Iterable[Path] = ()
) -> None:
    """Refuse a file that may not be written.

    Args:
        option: the option that names it, such as --output.
        force: replace a file that is there.
        suffix: the end that its name must have.
        keep: files that the command uses for something else.

    Raises:
        UserError: it may not be written, and why.
    """
    if suffix and path.suffix != suffix:
        raise UserError(f"{option} {path}: expected a name that ends in {suffix}")
    if path.is_dir():
        raise UserError(f"{option} {path}: is a folder, expected the name of a file")
    _check_place(path, option, force=force, keep=keep)


def _is_bag(path: Path) -> bool:
    from lagrangian_ff.recording.sources.bag import is_bag

    return is_bag(path)


def _is_library(path: Path) -> bool:
    """Return whether a folder was exported, and is that library still."""
    return all((path / name).is_file() for name in (f"{path.name}.c", "check.c", "CMakeLists.txt"))


FOLDERS: Mapping[str, Callable[[Path], bool]] = {"bag": _is_bag, "library": _is_library}
"""What a folder that --output names may be, and what says whether one that is there is it."""


def check_folder(
    path: Path, option: str, what: str, *, force: bool, keep: Iterable[Path] = ()
) -> None:
    """Refuse a folder, one of `FOLDERS`, that may not be written; see `check_file`.

    Raises:
        UserError: it may not, and why. A folder that holds anything else is never replaced.
    """
    if path.exists() and force and (path.is_file() or not FOLDERS[what](path)):
        raise UserError(f"{option} {path}: is not a {what} and is not replaced; name another")
    _check_place(path, option, force=force, keep=keep)


def _check_place(path: Path, option: str, *, force: bool, keep: Iterable[Path]) -> None:
    if any(path.resolve() == other.resolve() for other in keep):
        raise UserError(
            f"{option} {path}: this command uses that file for something else; name another"
        )
    if path.exists() and not force:
        raise UserError(
            f"{option} {path}: exists already; nothing was done. Name another, or replace it "
            "with --force"
        )
    if not path.parent.is_dir():
        raise UserError(f"{option} {path}: there is no folder {path.parent}; make it first")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise UserError(f"{option} {path}: no permission to write in {path.parent}")
    try:
        files.require_place(path)
    except OSError as error:
        raise UserError(f"{option} {path}: cannot be written: {error.strerror}") from error
    claim(path, option)


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Do as `files.whole`, with UserError where the file or bag cannot be written."""
    try:
        with files.whole(path) as made:
            yield made
    except OSError as error:
        raise UserError(f"{path}: cannot be written: {error.strerror or error}") from error


def write_record(target: str | None, record: Mapping[str, object]) -> None:
    """Write a record as JSON.

    Args:
        target: a file, "-" for standard output, None for nowhere.
        record: numbers that are not finite become null, as JSON has no word for them.
    """
    if target == "-":
        try:
            sys.stdout.write(to_json(record))
            sys.stdout.flush()
        except BrokenPipeError:
            silence(sys.stdout)
    elif target is not None:
        with whole(Path(target)) as path:
            path.write_text(to_json(record), encoding="utf-8")


def write_table(
    path: Path, time: "Floats", parts: "Mapping[str, Floats]", joints: Sequence[str]
) -> None:
    """Write CSV with the columns time and PART/JOINT; it reads back to the same numbers.

    Args:
        time: (M,) s.
        parts: by name (M, N), one column a joint.
    """
    columns = {"time": time}
    for part, values in parts.items():
        columns |= {f"{part}/{joint}": values[:, n] for n, joint in enumerate(joints)}
    with whole(path) as made, made.open("w", encoding="utf-8") as file:
        file.write(",".join(columns) + "\n")
        lists = [values.tolist() for values in columns.values()]
        file.writelines(",".join(map(repr, row)) + "\n" for row in zip(*lists, strict=True))
