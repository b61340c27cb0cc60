"""What an export wrote, and what that costs in N·m."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Protocol

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.identification import Model
from lagrangian_ff.record_json import by_name


@dataclass(frozen=True)
class Options:
    """What a user asked for beside the format.

    Attributes:
        settled: whether effects of the past, of time and of temperature are left settled.
        urdf: the robot's description.
        earlier: a model of the same arm at an earlier time.
        flange: the link of the description that the tool is fastened to.
    """

    settled: bool = False
    urdf: Path | None = None
    earlier: Model | None = None
    flange: str = "tool0"


@dataclass(frozen=True)
class Loss:
    """Something that a format does not hold.

    Attributes:
        what: in a few words.  rms: (N,) N·m of it on the model's recording.
    """

    what: str
    rms: Floats


@dataclass(frozen=True)
class Exported:
    """What an export wrote.

    Attributes:
        format: its name.
        files: what was written, the path that the user gave first.
        joints: N names, in the order of every array.
        losses: what the format does not hold.
        difference: (N,) N·m rms between the torque that was written and that of the model, on the
            recording that the model was learned from.
        model_error, error: (N,) N·m rms of the model, and of what was written, against the torque
            measured there.
        notes: what whoever uses the files must know.
        numbers: by name, what was written where that is a few numbers.
    """

    format: str
    files: tuple[str, ...]
    joints: tuple[str, ...]
    losses: tuple[Loss, ...]
    difference: Floats
    model_error: Floats
    error: Floats
    notes: tuple[str, ...] = ()
    numbers: Mapping[str, object] | None = None

    def record(self) -> dict[str, object]:
        """Return it as JSON holds it."""
        return by_name(self)


class Format(Protocol):
    """One format; a module with these names, listed in `formats`."""

    NAME: ClassVar[str]
    SUMMARY: ClassVar[str]
    SUFFIX: ClassVar[str]
    """How the name of the file ends; empty for a folder."""
    URDF: ClassVar[bool]
    """Whether it needs the robot's URDF."""

    def write(self, model: Model, path: Path, options: Options) -> Exported:
        """Write a model to a path that is free, under its final name in another folder.

        Raises:
            ExportError: the format cannot hold the model; says why.
        """


def exported(
    model: Model,
    name: str,
    files: tuple[str, ...],
    torque: Floats,
    losses: tuple[Loss, ...],
    notes: tuple[str, ...] = (),
    numbers: Mapping[str, object] | None = None,
) -> Exported:
    """Return what an export wrote whose torque on the model's data is (M, N) N·m."""
    whole = model.torque(model.inputs_of(model.data))
    measured = model.data.tau
    return Exported(
        format=name,
        files=files,
        joints=model.joints,
        losses=losses,
        difference=rms(torque - whole),
        model_error=rms(whole - measured),
        error=rms(torque - measured),
        notes=notes,
        numbers=numbers,
    )


def settled_torque(model: Model) -> Floats:
    """Return (M, N) N·m on the model's data, every state by itself."""
    return model.predict(model.data.q, model.data.qd, model.data.qdd)


def settled_losses(model: Model, settled: Mapping[str, str]) -> tuple[Loss, ...]:
    """Return what is lost where effects are left settled, by name with the reason."""
    if not settled:
        return ()
    data, basis, b = model.data, model.basis, model.coefficients
    moving = basis.torque(model.inputs_of(data), b)
    still = basis.torque(model.inputs(data.q, data.qd, data.qdd), b)
    return tuple(
        Loss(f"{name}, left settled: {why}", rms(moving[name] - still[name]))
        for name, why in settled.items()
    )


def rms(values: Floats) -> Floats:
    """Return (N,) the root mean square of (M, N)."""
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
