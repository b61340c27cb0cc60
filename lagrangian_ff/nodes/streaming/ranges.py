"""Where a reference leaves what the model was identified on."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification.motion_range import STILL

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


class Range(Protocol):
    """What was identified on, each (N,): rad, rad/s, rad/s², N·m."""

    @property
    def q_low(self) -> Floats: ...
    @property
    def q_high(self) -> Floats: ...
    @property
    def qd_max(self) -> Floats: ...
    @property
    def qdd_max(self) -> Floats: ...
    @property
    def tau_max(self) -> Floats: ...


@dataclass(frozen=True)
class Excess:
    """Which samples lie outside, and the worst of it in words (empty where none does).

    Attributes:
        outside: (L,) the sample lies outside.
        worst: the joint and quantity farthest outside.
    """

    outside: Flags
    worst: str


def excess(
    joints: tuple[str, ...], time: Floats, states: tuple[Floats, Floats, Floats],
    known: Range, margin: float,
) -> Excess:  # fmt: skip
    """Compare L states with the identified range widened by `margin` times its width.

    Args:
        joints: N names.
        time: (L,) s, for the words.
        states: q, qd, qdd, each (L, N).
        known: the identified range.
        margin: 0.25 lets each quantity go a quarter of its range beyond.
    """
    q, qd, qdd = states
    # A joint that stood still was identified in a point; give it a milliradian of width.
    half = np.maximum(0.5 * (known.q_high - known.q_low), STILL) * (1.0 + 2.0 * margin)
    middle = 0.5 * (known.q_high + known.q_low)
    # Distances from the middle, in units of half the range that counts as inside.
    relative = np.empty((3, *q.shape))
    np.divide(np.abs(q - middle), half, out=relative[0])
    np.divide(np.abs(qd), np.maximum(known.qd_max, STILL) * (1.0 + margin), out=relative[1])
    np.divide(np.abs(qdd), np.maximum(known.qdd_max, STILL) * (1.0 + margin), out=relative[2])
    if relative.max() <= 1.0:
        return Excess(np.zeros(len(q), dtype=bool), "")
    outside: Flags = np.asarray((relative > 1.0).any(axis=(0, 2)))
    kind, sample, joint = np.unravel_index(int(np.argmax(relative)), relative.shape)
    label, unit, values = (
        ("position", "rad", q), ("velocity", "rad/s", qd), ("acceleration", "rad/s²", qdd),
    )[kind]  # fmt: skip
    low, high = (
        (known.q_low[joint], known.q_high[joint]),
        (-known.qd_max[joint], known.qd_max[joint]),
        (-known.qdd_max[joint], known.qdd_max[joint]),
    )[kind]
    worst = (
        f"{label} of {joints[joint]} is {values[sample, joint]:.3g} {unit} at "
        f"{time[sample]:.3f} s; the model was identified between {low:.3g} and {high:.3g} {unit}"
    )
    return Excess(outside, worst)


def fade_around(time: Floats, outside: Flags, fade_time: float) -> Floats:
    """(L,) weight 0 in the samples outside, rising to 1 over `fade_time` s on both sides."""
    if not outside.any():
        return np.ones(len(time))
    instants = time[outside]
    after = np.clip(np.searchsorted(instants, time), 0, len(instants) - 1)
    before = np.maximum(after - 1, 0)
    distance = np.minimum(np.abs(time - instants[before]), np.abs(time - instants[after]))
    weight = np.where(outside, 0.0, np.minimum(1.0, distance / max(fade_time, 1e-9)))
    return np.asarray(weight, dtype=np.float64)
