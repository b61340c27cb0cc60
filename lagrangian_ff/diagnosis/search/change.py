"""Did the arm take up a load on the way? A second Lagrangian that begins at some moment.

A load at the hand changes masses, and with them the torque of every joint before it, in a pattern
that no curve over one joint's coordinate follows. What it adds is again a Lagrangian's torque, so
that the evidence is asked whether the rigid-body part has a second part from some moment on.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.ground import Ground, evidence_of
from lagrangian_ff.progress import Progress, silent

Floats = NDArray[np.float64]

ROWS = 1200
STEP, MARGIN = 5.0, 6.0
"""s between the moments tried, and from the ends of a motion."""
SHARE = 0.05
FINE = (0.005, 0.02, 0.08, 0.3, 1.0)
WORTH = 20.0
"""Nats that a change of the arm must be worth."""
PROMISING = 3.0
FELT = 0.02
"""Share of a joint's torque from which on the joint is said to feel a load."""


@dataclass(frozen=True)
class Change:
    """A load taken up.

    Attributes:
        since: s, from when on.
        share: variance of what is added, in parts of that of the rigid-body torque.
        gain: nats of log evidence.
    """

    since: float
    share: float
    gain: float


def change_of(ground: Ground, progress: Progress = silent) -> Change | None:
    """The moment at which the evidence gains most from a second Lagrangian.

    Few samples tell whether and roughly when, all of them how much. None where even the best
    moment is not worth it.
    """
    time = ground.seen.time
    if not np.isfinite(time).all() or float(np.ptp(time)) < 2.5 * MARGIN:
        return None
    first, last = float(time.min()) + MARGIN, float(time.max()) - MARGIN
    coarse = _gains(ground, ROWS)
    best = Change(first, SHARE, -np.inf)
    moments = np.arange(first, last, STEP)
    for number, since in enumerate(moments):
        progress(number / len(moments), "asking whether a load was taken up")
        gain = coarse(float(since), SHARE)
        if gain > best.gain:
            best = Change(float(since), SHARE, gain)
    if best.gain < PROMISING:
        return None
    for step in (STEP / 2.0, STEP / 4.0, STEP / 8.0):
        for since in (best.since - step, best.since + step):
            gain = coarse(since, best.share)
            if gain > best.gain:
                best = Change(since, best.share, gain)
    for share in FINE:
        gain = coarse(best.since, share)
        if gain > best.gain:
            best = Change(best.since, share, gain)
    whole = _gains(ground, len(ground.index) * ground.joints)
    best = replace(best, gain=whole(best.since, best.share))
    return best if best.gain > WORTH else None


def joints_of(ground: Ground) -> tuple[tuple[int, ...], Floats]:
    """Which joints feel the change that is in a ground's prior.

    Returns:
        Their indices, the most affected first, and (N,) the root mean square of the added torque
        over that of each joint's torque.
    """
    weights = ground.system.weights.reshape(len(ground.index), ground.joints)
    x = ground.seen
    added = ground.prior.torque(x, x, weights)
    added -= replace(ground.prior, change=None).torque(x, x, weights)
    share = np.sqrt(np.mean(added**2, axis=0)) / np.maximum(ground.spread, 1e-12)
    order = [int(n) for n in np.argsort(-share) if share[n] > FELT]
    return tuple(order or [int(np.argmax(share))]), share


def _gains(ground: Ground, rows: int) -> Callable[[float, float], float]:
    evidence = evidence_of(ground.motion, ground.inputs, ground.basis, rows, ground.extra, ground)
    plain = evidence(replace(ground.prior, change=None))
    return lambda since, share: evidence(replace(ground.prior, change=(since, share))) - plain
