"""The folder the demo writes into, and what of an earlier demo it replaces."""

import shutil
from dataclasses import dataclass
from pathlib import Path

from lagrangian_ff.errors import UserError


@dataclass(frozen=True)
class Folder:
    """Paths of everything the demo leaves behind.

    Attributes:
        root: the folder.
    """

    root: Path

    @property
    def page(self) -> Path:
        """The page that shows everything."""
        return self.root / "index.html"

    @property
    def record(self) -> Path:
        """All numbers as JSON."""
        return self.root / "demo.json"

    @property
    def model(self) -> Path:
        """The identified model."""
        return self.root / "model.npz"

    @property
    def recording(self) -> Path:
        """Where the identify node puts its bag."""
        return self.root / "recording"

    @property
    def unseen(self) -> Path:
        """Bag of the motion the model never saw."""
        return self.root / "unseen_motion"

    @property
    def logs(self) -> Path:
        """What the nodes print."""
        return self.root / "logs"

    def picture(self, name: str) -> Path:
        """A picture of this name."""
        return self.root / f"{name}.png"

    def prepare(self) -> None:
        """Make the folder, and remove the recordings and results of an earlier demo.

        Raises:
            UserError: it cannot be made or written.
        """
        try:
            self.root.mkdir(parents=True, exist_ok=True)
            for path in (self.recording, self.unseen, self.logs):
                _remove(path)
            for path in (self.page, self.record, self.model):
                path.unlink(missing_ok=True)
            self.logs.mkdir()
        except OSError as error:
            raise UserError(
                f"{error.filename or self.root}: cannot be written: {error.strerror}"
            ) from error

    def bag(self) -> Path:
        """The bag the identify node made."""
        return max(path for path in self.recording.iterdir() if path.is_dir())


def _remove(path: Path) -> None:
    """Remove a folder of an earlier demo, but not one that holds something else.

    Raises:
        UserError: it does.
    """
    if not path.exists():
        return
    ours = (".mcap", ".yaml", ".npz", ".log", ".part")
    strange = [p for p in path.rglob("*") if p.is_file() and p.suffix not in ours]
    if strange or not path.is_dir():
        raise UserError(
            f"{path}: holds {(strange or [path])[0].name}, which is not of an earlier demo; move "
            "it away or choose another folder with --output"
        )
    shutil.rmtree(path)
