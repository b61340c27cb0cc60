"""The output folder of the demo; it replaces an earlier demo."""

import shutil
from pathlib import Path

from lagrangian_ff.errors import UserError


class Folder:
    """Paths of everything the demo leaves behind.

    Attributes:
        root: the folder.
        page: shows everything.  record: all numbers as JSON.  model: the identified model.
        recording: folder of the identify node's bag.
        unseen: bag of the motion the model never saw.
        logs: output of the nodes.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self.page, self.record = root / "index.html", root / "demo.json"
        self.model, self.recording = root / "model.npz", root / "recording"
        self.unseen, self.logs = root / "unseen_motion", root / "logs"

    def picture(self, name: str) -> Path:
        """Return the path of a picture."""
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
            path = error.filename or self.root
            raise UserError(f"{path}: cannot be written: {error.strerror}") from error

    def bag(self) -> Path:
        """Return the bag the identify node made."""
        return max(path for path in self.recording.iterdir() if path.is_dir())


def _remove(path: Path) -> None:
    """Remove a folder of an earlier demo; raise UserError if it holds something else."""
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
