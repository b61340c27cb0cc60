"""What the error is looked at against, listed once; a new coordinate is one entry here."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.where import phrases
from lagrangian_ff.diagnosis.where.course import Course
from lagrangian_ff.diagnosis.where.reversals import before_reversal, direction, since_reversal

Floats = NDArray[np.float64]

OUTSIDE = 0.05
"""From which excess, in parts of the range, a state counts as outside what the model knows."""


@dataclass(frozen=True)
class Coordinate:
    """Something a residual may depend on.

    Attributes:
        name: as in records.
        unit: SI, empty for a number.
        label: of an axis, without the unit.
        values: (M,) of a course and a joint; NaN where it has none.
        words: from low, high, and the lowest and highest value met, as in "below 0.1 rad/s".
        levels: its values where it has only few, such as the two directions.
        binned: whether the mean residual is averaged over it; a magnitude is for regions only.
    """

    name: str
    unit: str
    label: str
    values: Callable[[Course, int], Floats]
    words: Callable[[float, float, float, float], str]
    levels: tuple[float, ...] = ()
    binned: bool = True


COORDINATES: dict[str, Coordinate] = {
    one.name: one
    for one in (
        Coordinate(
            "speed", "rad/s", "speed", lambda c, j: np.abs(c.motion.qd[:, j]), phrases.speed,
            binned=False,
        ),
        Coordinate(
            "velocity", "rad/s", "velocity", lambda c, j: c.motion.qd[:, j], phrases.velocity
        ),
        Coordinate("position", "rad", "position", lambda c, j: c.motion.q[:, j], phrases.position),
        Coordinate(
            "acceleration", "rad/s²", "acceleration", lambda c, j: c.motion.qdd[:, j],
            phrases.acceleration,
        ),
        Coordinate("load", "N·m", "load (rigid-body torque)", lambda c, j: c.load[:, j],
                   phrases.load),
        Coordinate(
            "load_size", "N·m", "size of the load", lambda c, j: np.abs(c.load[:, j]),
            phrases.load_size, binned=False,
        ),
        Coordinate(
            "since_reversal", "s", "time since the joint turned round",
            lambda c, j: since_reversal(c.motion, j), phrases.since_reversal,
        ),
        Coordinate(
            "before_reversal", "s", "time until the joint turns round",
            lambda c, j: before_reversal(c.motion, j), phrases.before_reversal,
        ),
        Coordinate("time", "s", "time", lambda c, j: c.motion.elapsed, phrases.time),
        Coordinate(
            "direction", "", "direction of motion", lambda c, j: direction(c.motion, j),
            phrases.direction, levels=(-1.0, 1.0),
        ),
        Coordinate(
            "outside_range", "", "outside the range the model knows",
            lambda c, j: (c.excess > OUTSIDE).astype(np.float64), phrases.outside_range,
            levels=(0.0, 1.0),
        ),
    )
}  # fmt: skip
"""By name. Where two say the same thing equally well, the one listed first is named."""

PAIRS: tuple[tuple[str, str], ...] = (
    ("speed", "since_reversal"),
    ("speed", "before_reversal"),
    ("speed", "direction"),
    ("speed", "position"),
    ("speed", "load_size"),
    ("position", "direction"),
    ("load", "direction"),
)
"""Which coordinates are looked at together."""
