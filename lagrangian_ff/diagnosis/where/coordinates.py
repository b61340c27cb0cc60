"""The coordinates that an error may depend on, listed once; a new one is one entry here."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.compare import OUTSIDE
from lagrangian_ff.diagnosis.where.series import ResidualSeries
from lagrangian_ff.effects.reversals import before_reversal, direction, since_reversal
from lagrangian_ff.numbers import typeset

Values = Callable[[ResidualSeries, int], Floats]
Words = Callable[[float, float, float, float], str]
"""From low, high, and the lowest and highest value met in the motion: an end of an interval that
lies at the edge of the motion need not be said."""

NEAR = 0.02
"""Of the width of all values: an end so close to the edge of the motion is the edge."""


@dataclass(frozen=True)
class Coordinate:
    """Something that a residual may depend on.

    Attributes:
        name: as in records.  unit: SI, empty for a number.
        label: of an axis, without the unit.
        values: (M,) of a series and a joint; NaN where it has none.
        words: an interval as a person would say it, as in "below 0.1 rad/s".
        levels: its values with a word for each, where it has only few, such as the two directions.
        binned: whether the mean residual is averaged over it; a magnitude is for regions only.
    """

    name: str
    unit: str
    label: str
    values: Values
    words: Words
    levels: Mapping[float, str] = field(default_factory=dict)
    binned: bool = True


def percent(share: float) -> str:
    """Return a share in whole percent, finer below one."""
    return f"{100.0 * share:.0f} %" if share >= 0.00995 else f"{100.0 * share:.1f} %"


def _interval(
    unit: str, below: str, above: str, between: str, *, positive: bool = False, link: str = "and"
) -> Words:
    """Return the words of an interval: what is said before its end or ends, with the unit.

    Args:
        unit: of the numbers.
        below, above, between: what is said before the numbers.
        positive: whether no value lies below zero.
        link: what is said between two numbers.
    """

    def words(low: float, high: float, lowest: float, highest: float) -> str:
        lowest = 0.0 if positive else lowest
        slack = NEAR * (highest - lowest)
        low, high = (0.0 if abs(end) < 0.2 * slack else end for end in (low, high))
        from_lowest, to_highest = low <= lowest + slack, high >= highest - slack
        if from_lowest and to_highest:
            # Nearly all of the range, in less of the time: the end that is farther in is said.
            from_lowest = highest - high > low - lowest
        if from_lowest:
            return f"{below} {typeset(high, 2)} {unit}"
        if to_highest:
            return f"{above} {typeset(low, 2)} {unit}"
        return f"{between} {typeset(low, 2)} {link} {typeset(high, 2)} {unit}"

    return words


def _signed(unit: str, what: str) -> Words:
    return _interval(unit, f"{what} below", f"{what} above", f"{what} between")


def _velocity(low: float, high: float, lowest: float, highest: float) -> str:
    """Return the words of a signed velocity; one that is symmetric about zero is a speed."""
    if low < 0.0 < high and abs(low + high) < 1e-9 * (high - low):
        return f"below {typeset(high, 2)} rad/s"
    return _signed("rad/s", "at velocities")(low, high, lowest, highest)


def _either(positive: str, other: str) -> Words:
    return lambda low, high, lowest, highest: positive if low > 0.0 else other


def _near_reversal(seconds: Callable[..., Floats]) -> Values:
    return lambda s, j: seconds(s.motion.time, s.motion.qd[:, j], s.motion.segment)


COORDINATES: dict[str, Coordinate] = {
    one.name: one
    for one in (
        Coordinate(
            "speed", "rad/s", "speed", lambda s, j: np.abs(s.motion.qd[:, j]),
            _interval("rad/s", "below", "above", "between", positive=True), binned=False,
        ),
        Coordinate("velocity", "rad/s", "velocity", lambda s, j: s.motion.qd[:, j], _velocity),
        Coordinate(
            "position", "rad", "position", lambda s, j: s.motion.q[:, j],
            _signed("rad", "at positions"),
        ),
        Coordinate(
            "acceleration", "rad/s²", "acceleration", lambda s, j: s.motion.qdd[:, j],
            _signed("rad/s²", "at accelerations"),
        ),
        Coordinate(
            "load", "N·m", "load (rigid-body torque)", lambda s, j: s.load[:, j],
            _signed("N·m", "under a load"),
        ),
        Coordinate(
            "load_size", "N·m", "size of the load", lambda s, j: np.abs(s.load[:, j]),
            _interval(
                "N·m", "under a load smaller than", "under a load greater than",
                "under a load of between", positive=True,
            ),
            binned=False,
        ),
        Coordinate(
            "since_reversal", "s", "time since the joint turned round",
            _near_reversal(since_reversal),
            _interval(
                "s", "after a reversal, within", "after a reversal, later than",
                "after a reversal, between", positive=True,
            ),
        ),
        Coordinate(
            "before_reversal", "s", "time until the joint turns round",
            _near_reversal(before_reversal),
            _interval(
                "s", "before a reversal, within", "before a reversal, by more than",
                "before a reversal, between", positive=True,
            ),
        ),
        Coordinate(
            "time", "s", "time", lambda s, j: s.motion.elapsed,
            _interval("s", "in the first", "after", "from", link="to"),
        ),
        Coordinate(
            "direction", "", "direction of motion",
            lambda s, j: direction(s.motion.qd[:, j], s.motion.segment),
            _either("moving forwards", "moving backwards"),
            levels={-1.0: "backwards", 1.0: "forwards"},
        ),
        Coordinate(
            "rest", "", "standing still",
            lambda s, j: s.still[:, j].astype(np.float64), _either("standing still", "moving"),
            levels={0.0: "moving", 1.0: "standing still"}, binned=False,
        ),
        Coordinate(
            "outside_range", "", "outside the range the model knows",
            lambda s, j: (s.excess > OUTSIDE).astype(np.float64),
            _either(
                "outside the range the model was identified on",
                "inside the range the model was identified on",
            ),
            levels={0.0: "inside", 1.0: "outside"},
        ),
    )
}  # fmt: skip
"""By name. Where two say the same thing equally well, the one listed first is named."""

APART = ("time", "rest")
"""Searched for themselves: when a model failed, and that it stood still, do not answer where."""

PAIRS: tuple[tuple[str, str], ...] = (
    ("speed", "since_reversal"),
    ("speed", "before_reversal"),
    ("speed", "direction"),
    ("speed", "position"),
    ("speed", "load_size"),
    ("position", "direction"),
    ("load", "direction"),
)
"""The coordinates that are looked at together."""
