"""Files and folders that are written whole or not at all."""

import errno
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def require_place(path: Path) -> None:
    """Require that a file can be made where `whole` will make it, by making one and removing it.

    Permissions alone do not say so: a disk may be full or read-only, a name too long.

    Raises:
        OSError: it cannot; says why.
    """
    try:
        with tempfile.TemporaryDirectory(prefix=f".{path.name[:50]}.", dir=path.parent) as aside:
            (Path(aside) / path.name).write_bytes(b"0")
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Yield where to write a file or a folder; it replaces `path` when the block ends well.

    If the block fails, Ctrl-C included, `path` stays as it was and nothing else is left. Several
    processes may write the same path at once: each writes aside, and the last one stays.

    Raises:
        OSError: the folder of `path` cannot be written to, or a file would replace a folder.
    """
    try:
        aside = Path(tempfile.mkdtemp(prefix=f".{path.name[:50]}.", dir=path.parent))
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error
    before = aside / "replaced"
    try:
        made = aside / path.name
        yield made
        if path.is_dir():
            if made.is_file():
                raise IsADirectoryError(errno.EISDIR, "there is a folder of that name", str(path))
            path.rename(before)
        made.replace(path)
    finally:
        if before.exists() and not path.exists():
            before.rename(path)
        shutil.rmtree(aside, ignore_errors=True)
