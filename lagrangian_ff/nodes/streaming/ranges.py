"""The excess of a reference over the identified range, and the model's doubt along it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Flags, Floats
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.certainty.uncertainty import quick_factor
from lagrangian_ff.identification.predicting import STILL, MotionRange
from lagrangian_ff.nodes.common.status import Level, Status

Doubts = Callable[[Floats, Floats, Floats], Floats]
"""The doubt (L, N) of each torque for q, qd, qdd, (L, N) each."""

GUESS = 1.0
"""Doubt from which on a torque counts as a guess: not even its sign is known."""
PAUSE = 0.1
"""s between two evaluations while set-points are streamed: one takes milliseconds."""
STEP = 0.05
"""s between the evaluated states of a trajectory: far less than a motion changes in."""
CHUNK = 4
"""States evaluated at once: between calls other threads get their turn."""


@dataclass(frozen=True)
class Excess:
    """The samples outside the identified range.

    Attributes:
        outside: (L,) whether each sample lies outside.
        worst: the joint and quantity farthest outside, in words; empty if none is.
    """

    outside: Flags
    worst: str


def excess(
    joints: tuple[str, ...],
    time: Floats,
    states: tuple[Floats, Floats, Floats],
    known: MotionRange,
    margin: float,
) -> Excess:
    """Compare L states with the identified range, widened by `margin` times its width.

    Args:
        time: (L,) s, for the words.
        states: q, qd, qdd, each (L, N).
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
    label, unit, values, low, high = (
        ("position", "rad", q, known.q_low, known.q_high),
        ("velocity", "rad/s", qd, -known.qd_max, known.qd_max),
        ("acceleration", "rad/s²", qdd, -known.qdd_max, known.qdd_max),
    )[kind]
    worst = (
        f"{label} of {joints[joint]} is {values[sample, joint]:.3g} {unit} at {time[sample]:.3f} "
        f"s; the model was identified between {low[joint]:.3g} and {high[joint]:.3g} {unit}"
    )
    return Excess(outside, worst)


def fade_around(time: Floats, outside: Flags, fade_time: float) -> Floats:
    """Return the weight (L,): 0 in the samples outside, rising to 1 over `fade_time` s around."""
    if not outside.any():
        return np.ones(len(time))
    instants = time[outside]
    after = np.clip(np.searchsorted(instants, time), 0, len(instants) - 1)
    before = np.maximum(after - 1, 0)
    distance = np.minimum(np.abs(time - instants[before]), np.abs(time - instants[after]))
    weight = np.where(outside, 0.0, np.minimum(1.0, distance / max(fade_time, 1e-9)))
    return np.asarray(weight, dtype=np.float64)


class Doubt:
    """Half of the 90 % interval of a torque over the largest torque identified on its joint.

    It sees what the range of motion cannot: combinations of states, and what the kernel makes of
    them. The share of the variance that is not noise would not do here: on a wrist with little
    noise it is near 1 on known motion, too.

    Raises:
        ModelError: the model cannot be calibrated.
    """

    def __init__(self, model: Model) -> None:
        self._certain = model.quick_uncertainty
        self._scale = 1.0 / np.maximum(model.range.tau_max, 1e-9)
        self._last = np.zeros((1, len(model.joints)))
        middle = 0.5 * (model.range.q_low + model.range.q_high)[None]
        self(middle, 0.0 * middle, 0.0 * middle)  # builds what is built on first use

    @classmethod
    def of(cls, model: Model) -> "Doubt | None":
        """Return the doubt of a model; None if its file has no calibration, which takes long."""
        return None if quick_factor(model) is None else cls(model)

    def __call__(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """Return the doubt (L, N) at L states."""
        return np.asarray(self._certain.reach(q, qd, qdd) * self._scale)

    def look(self, q: Floats, qd: Floats, qdd: Floats) -> None:
        """Evaluate one state, (1, N) each, for `latest`."""
        self._last = self(q, qd, qdd)

    def latest(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """Return the result (1, N) of the last `look` at once, whatever the state."""
        return self._last


def along(
    doubts: Doubts,
    times: Floats,
    states: tuple[Floats, Floats, Floats],
    report: Callable[[], None] = lambda: None,
) -> Floats:
    """Return the doubt (L, N) along L states, each that of a state at most `STEP` s before.

    Args:
        times: (L,) s, increasing.
        states: q, qd, qdd, (L, N) each.
        report: called after each chunk; may raise to cancel.
    """
    some = np.unique(np.searchsorted(times, np.arange(times[0], times[-1] + STEP, STEP)))
    some = some[some < len(times)]
    found = []
    for first in range(0, len(some), CHUNK):
        rows = some[first : first + CHUNK]
        found.append(doubts(*(array[rows] for array in states)))
        report()
    nearest = np.searchsorted(some, np.arange(len(times)), side="right") - 1
    return np.concatenate(found)[nearest]


def doubt_words(
    joints: tuple[str, ...], times: Floats, doubt: Floats, largest: Floats, limit: float
) -> str:
    """Return the place and size in N·m of the largest doubt (L, N) above the limit, or ""."""
    if not (doubt > limit).any():
        return ""
    sample, joint = np.unravel_index(int(np.argmax(doubt)), doubt.shape)
    reach = float(doubt[sample, joint] * largest[joint])
    return (
        f"the torque of {joints[joint]} is known to ±{reach:.3g} N·m only at {times[sample]:.3f} "
        f"s; the largest identified is {largest[joint]:.3g} N·m"
    )


def doubt_status(
    joints: tuple[str, ...], known: bool, doubt: Floats | None, limit: float
) -> Status:
    """Return how sure the torques of the present reference are.

    Args:
        known: whether the model file keeps a calibration.
        doubt: (N,) the largest along the reference; None without one.
        limit: above which a torque fades; 0 = never.
    """
    if not known:
        return Status(
            Level.OK, "the model file is too old to hold how sure it is; identify again to see it"
        )
    if doubt is None:
        return Status(Level.OK, "no reference")
    values = {f"doubt {joint}": float(one) for joint, one in zip(joints, doubt, strict=True)}
    unsure = [n for n in np.argsort(-doubt) if doubt[n] > (limit or GUESS)]
    if unsure:
        few = ", ".join(f"{joints[n]} (±{doubt[n]:.0%} of its largest)" for n in unsure)
        return Status(Level.WARN, f"the torque is a guess: {few}", values)
    worst = int(np.argmax(doubt))
    message = f"known to {doubt[worst]:.0%} of the largest torque or better ({joints[worst]})"
    return Status(Level.OK, message, values)
