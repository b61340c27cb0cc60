"""What was measured, exactly as it came."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.errors import RecordingError

Floats = NDArray[np.float64]


def columns_of(wanted: Sequence[str], held: Sequence[str], source: str) -> list[int]:
    """Where the wanted joints stand among those that a source holds.

    Raises:
        RecordingError: one is not there; names both lists.
    """
    missing = [name for name in wanted if name not in held]
    if missing:
        raise RecordingError(f"{source}: no joint {', '.join(missing)}; it holds {', '.join(held)}")
    return [held.index(name) for name in wanted]


@dataclass(frozen=True)
class Recording:
    """Joint states as they were recorded: nothing sorted, filled, scaled or dropped.

    Attributes:
        joints: N joint names; the columns of every array follow them.
        time: (M,) seconds of each sample since `start`, from the message stamps, in order of
            arrival.
        position: (M, N) rad (m for prismatic joints).
        velocity: (M, N) rad/s; NaN where it was not given.
        effort: (M, N) in the driver's unit, N·m unless scaled later; NaN where it was not given.
        start: seconds since the Unix epoch of the first sample; 0 where unknown.
        source: the file or topic it came from, for messages.
        notes: what the reader met on the way, in words.
    """

    joints: tuple[str, ...]
    time: Floats
    position: Floats
    velocity: Floats
    effort: Floats
    start: float = 0.0
    source: str = "memory"
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if len(set(self.joints)) != len(self.joints):
            raise RecordingError(f"{self.source}: a joint is named twice: {list(self.joints)}")
        shape = (self.time.shape[0], len(self.joints))
        for name in ("position", "velocity", "effort"):
            found = getattr(self, name).shape
            if found != shape:
                raise RecordingError(
                    f"{self.source}: {name} has shape {found}, expected {shape} (samples, joints)"
                )

    def __len__(self) -> int:
        return int(self.time.shape[0])

    def select(self, joints: tuple[str, ...]) -> "Recording":
        """Keep these joints, in this order.

        Raises:
            RecordingError: a joint is not in the recording; names both lists.
        """
        columns = columns_of(joints, self.joints, self.source)
        return replace(
            self,
            joints=tuple(joints),
            position=self.position[:, columns],
            velocity=self.velocity[:, columns],
            effort=self.effort[:, columns],
        )
