"""The model of the stream: made ready, and replaced when its file is."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from lagrangian_ff.arrays import Ints
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model
from lagrangian_ff.nodes.common.models import OneStateModel, load_model
from lagrangian_ff.nodes.streaming.plan import reason
from lagrangian_ff.nodes.streaming.ranges import Doubt


@dataclass(frozen=True)
class ReadyModel:
    """A model that was loaded, tried on one state, and has built what it builds on first use.

    Attributes:
        file: as the user names it.
        model: for trajectories.
        columns: for each torque of a command its column in the model.
        one_state: the model for set-points.
        doubt: how far its torques are a guess; None if the file has no calibration.
    """

    file: str
    model: Model
    columns: Ints
    one_state: OneStateModel
    doubt: Doubt | None

    @classmethod
    def load(cls, file: str, joints: tuple[str, ...] = ()) -> "ReadyModel":
        """Load a model; `joints` is the order of the torques, empty for that of the model.

        Raises:
            ModelError: see `load_model`.
        """
        model, columns = load_model(file, joints)
        return cls(file, model, columns, OneStateModel(model), Doubt.of(model))


class ModelFile:
    """Loads a model file, and loads it in a thread again when it is replaced.

    A file counts as replaced when it changed and then stayed as it is from one `look` to the next,
    so that half a file is not taken.

    Args:
        name: returns the file, which the user may change.
        joints: the order of the torques; empty for that of the model.

    Attributes:
        first: the model that was loaded at the start.
        refusal: why the file as it is now is not used; empty if it is.

    Raises:
        ModelError: see `load_model`.
    """

    def __init__(self, name: Callable[[], str], joints: tuple[str, ...]) -> None:
        self._name, self._joints = name, joints
        self._tried = self._seen = _signature(name())
        self.first = ReadyModel.load(name(), joints)
        self.refusal = ""
        self._coming: ReadyModel | None = None
        self._thread: threading.Thread | None = None

    def look(self) -> None:
        """Look at the file; begin to load it if it was replaced. For a call a second."""
        signature, before = _signature(self._name()), self._seen
        self._seen = signature
        loading = self._thread is not None and self._thread.is_alive()
        if loading or signature != before or signature == self._tried:
            return
        self._tried = signature
        self._thread = threading.Thread(target=self._load, name="model", daemon=True)
        self._thread.start()

    def take(self) -> ReadyModel | None:
        """Return the model that takes over now, once; None without one."""
        coming, self._coming = self._coming, None
        return coming

    def _load(self) -> None:
        name = self._name()
        try:
            ready = ReadyModel.load(name, self._joints)
            was, now = self.first.model.joints, ready.model.joints
            if now != was:
                raise ModelError(
                    f"{name} is a model of {', '.join(now)}, in use is one of {', '.join(was)}; "
                    "clean up and configure the node to change the joints"
                )
        except Exception as error:
            self.refusal = reason(error)
        else:
            self.refusal, self._coming = "", ready


def _signature(name: str) -> tuple[str, int, int, int]:
    """Return what differs when a file is replaced; zeros without a file."""
    try:
        found = Path(name).expanduser().stat()
    except OSError:
        return name, 0, 0, 0
    return name, found.st_mtime_ns, found.st_size, found.st_ino
