"""How far the torques of a reference are a guess, from the predictive variance of the model."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification import Model
from lagrangian_ff.identification.certainty.uncertainty import quick_factor
from lagrangian_ff.nodes.common.status import Level, Status

Floats = NDArray[np.float64]
Doubts = Callable[[Floats, Floats, Floats], Floats]
"""(L, N) doubt of each torque for q, qd, qdd, (L, N) each."""

GUESS = 1.0
"""Doubt from which on a torque is told to be a guess: not even its sign is known."""
PAUSE = 0.1
"""s between two looks where set-points are streamed: one takes milliseconds."""
STEP = 0.05
"""s between the states of a trajectory that are asked for: far less than a motion changes in."""
CHUNK = 4
"""States asked for at once: between calls other threads get their turn."""


class Doubt:
    """Half of the 90 % interval of a torque over the largest torque identified on its joint.

    It tells what the range of motion cannot: combinations of states, and what the kernel makes of
    them. The share of the variance that is not noise would not do here: on a wrist with little
    noise it is near 1 on known motion, too.

    Args:
        model: whose torques.

    Raises:
        ModelError: the model cannot be calibrated.
    """

    def __init__(self, model: Model) -> None:
        self._certain = model.quick_uncertainty
        self._scale = 1.0 / np.maximum(model.range.tau_max, 1e-9)
        self._last = np.zeros((1, len(model.joints)))
        middle = 0.5 * (model.range.q_low + model.range.q_high)[None]
        self(middle, 0.0 * middle, 0.0 * middle)  # what is made on first use is made now

    @classmethod
    def of(cls, model: Model) -> "Doubt | None":
        """None for models of before the calibration was kept: to make it anew takes too long."""
        return None if quick_factor(model) is None else cls(model)

    def __call__(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """(L, N) at L states."""
        return np.asarray(self._certain.reach(q, qd, qdd) * self._scale)

    def look(self, q: Floats, qd: Floats, qdd: Floats) -> None:
        """Ask at one state, (1, N) each; `latest` tells the answer from then on."""
        self._last = self(q, qd, qdd)

    def latest(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """(1, N) the answer to the last `look`, at once, whatever state is asked for."""
        return self._last


def along(
    doubts: Doubts,
    times: Floats,
    states: tuple[Floats, Floats, Floats],
    report: Callable[[], None] = lambda: None,
) -> Floats:
    """(L, N) the doubt along L states in time, each that of a state at most `STEP` s before.

    Args:
        doubts: of any states.
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


def words(
    joints: tuple[str, ...], times: Floats, doubt: Floats, largest: Floats, limit: float
) -> str:
    """Where a doubt (L, N) above the limit is largest, with the N·m it means; else empty."""
    if not (doubt > limit).any():
        return ""
    sample, joint = np.unravel_index(int(np.argmax(doubt)), doubt.shape)
    reach = float(doubt[sample, joint] * largest[joint])
    return (
        f"the torque of {joints[joint]} is known to ±{reach:.3g} N·m only at {times[sample]:.3f} "
        f"s; the largest identified is {largest[joint]:.3g} N·m"
    )


def status(joints: tuple[str, ...], asked: bool, doubt: Floats | None, limit: float) -> Status:
    """How sure the torques of the present reference are.

    Args:
        joints: N names.
        asked: whether the model tells its doubt.
        doubt: (N,) the largest along the reference; None without one.
        limit: above which a torque fades; 0 = never.
    """
    if not asked:
        return Status(
            Level.OK,
            "the model file is of before it kept how sure it is; identify again to be told",
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
