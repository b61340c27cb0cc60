"""Files that a command writes: refused early where they would destroy something, whole or not at
all afterwards."""

import os
import shutil
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.errors import UserError
from lagrangian_ff.record_json import to_json

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


def check_file(
    path: Path, option: str, *, force: bool, suffix: str = "", keep: Iterable[Path] = ()
) -> None:
    """Whether a file may be written: asked before any long work.

    Args:
        path: where.
        option: what the user named it with, such as --output.
        force: replace a file that is there.
        suffix: what its name must end in.
        keep: what is read or written by the same command and must not be replaced.

    Raises:
        UserError: it may not, and why.
    """
    if suffix and path.suffix != suffix:
        raise UserError(f"{option} {path}: expected a name that ends in {suffix}")
    if path.is_dir():
        raise UserError(f"{option} {path}: is a folder, expected the name of a file")
    _check_place(path, option, force=force, keep=keep)


def check_bag(path: Path, option: str, *, force: bool, keep: Iterable[Path] = ()) -> None:
    """Whether a bag (a folder) may be written: asked before any long work.

    Raises:
        UserError: it may not, and why. A folder that holds anything but a bag is never replaced.
    """
    from lagrangian_ff.recording.bag_folder import is_bag

    if path.exists() and force and (path.is_file() or not is_bag(path)):
        raise UserError(f"{option} {path}: is not a bag and is not replaced; name another")
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


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """A path to write a file or a bag to; it takes its place only when the block ends well.

    Whatever ends the block otherwise, Ctrl-C too, leaves what was there and nothing else.

    Raises:
        UserError: it cannot be written.
    """
    try:
        aside = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
    except OSError as error:
        raise UserError(f"{path}: cannot be written: {error.strerror}") from error
    before = aside / "replaced"
    try:
        made = aside / path.name
        yield made
        if path.is_dir():
            path.rename(before)
        made.replace(path)
    except OSError as error:
        raise UserError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        if before.exists() and not path.exists():
            before.rename(path)
        shutil.rmtree(aside, ignore_errors=True)


def write_record(target: str | None, record: Mapping[str, object]) -> None:
    """Write a record as JSON.

    Args:
        target: a file, "-" for standard output, None for nowhere.
        record: numbers that are not finite become null, as JSON has no word for them.
    """
    if target is None:
        return
    text = to_json(record)
    if target == "-":
        sys.stdout.write(text)
        return
    with whole(Path(target)) as path:
        path.write_text(text, encoding="utf-8")


def write_table(path: Path, columns: "Mapping[str, NDArray[np.float64]]") -> None:
    """Write equally long columns as CSV that reads back to the same numbers."""
    with whole(path) as made, made.open("w", encoding="utf-8") as file:
        file.write(",".join(columns) + "\n")
        lists = [values.tolist() for values in columns.values()]
        file.writelines(",".join(map(repr, row)) + "\n" for row in zip(*lists, strict=True))
