"""The noise floor: by how much the same motion differs from itself."""

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.diagnosis.preflight.base import Case, Check, duration_of, rate_of, thinned
from lagrangian_ff.recording.motion import Motion

SEARCHED = 10.0
"""Hz, at which repeats are looked for."""
LEAST = 4.0
"""Time in s that the two must move together."""
AT_FLOOR = 1.3
"""Factor: an error below this times the floor leaves nothing to explain."""
REPEATED = 0.5
"""Least share of a recording to call it a repeat of the motion."""
_MOST = 1200  # samples that are compared with each other
_APART = 2.0  # s, a motion is not its own repeat
_CLOSE = 0.06  # of a joint's range and speed range, at SEARCHED
_SAME = 0.02  # at the full rate
_MOVING = 0.05  # of the top speed of some joint
_IDENTICAL = 1e-9
_AROUND = 0.15  # s, in which the lag is refined


def check_noise(case: Case) -> list[Check]:
    """Report the spread of torque between repeats, of the same recording or of another.

    Also report another recording, meant to confirm, that is mostly such a repeat.
    """
    spread = (
        np.maximum(np.ptp(case.motion.q, axis=0), 1e-9),
        np.maximum(np.abs(case.motion.qd).max(axis=0), 1e-9),
    )
    best: tuple[float, Motion, float] | None = None
    for other in (case.motion, *case.others):
        lag = _lag(case.motion, other, spread)
        if lag is not None and (best is None or lag[1] > best[0]):
            best = (lag[1], other, lag[0])
    if best is None:
        return []
    found = _floor(case, best[1], best[2], spread)
    if found is None:
        return []
    floor, seconds = found
    if np.all(floor <= _IDENTICAL * np.abs(case.motion.tau).max(axis=0)):
        # The same measurement given twice says nothing of noise.
        return []
    error = np.sqrt((case.residual**2).mean(axis=0))
    floors = []
    for n, name in enumerate(case.joints):
        finding = (
            f"{seconds:.0f} s of the motion occur twice: there {name} differs from itself by "
            f"{floor[n]:.3g} N·m; the model's error is {error[n]:.3g} N·m"
        )
        if error[n] < AT_FLOOR * floor[n]:
            finding += ", as small as that"
        values = {"floor": floor[n], "error": error[n], "seconds": seconds}
        floors.append(Check("noise floor", name, finding, values=values))
    return [*_repeated(case, best[1], seconds), *floors]


def _repeated(case: Case, other: Motion, seconds: float) -> list[Check]:
    """Return a remark if most of another recording is the motion that is searched."""
    if other is case.motion or seconds < REPEATED * duration_of(other):
        return []
    finding = (
        f"{other.source} repeats {seconds:.0f} s of the motion that is searched: it shows that "
        "an error comes again, but hardly what causes it"
    )
    advice = "Confirm on another motion"
    return [Check("repeated motion", None, finding, advice=advice, values={"seconds": seconds})]


def _lag(one: Motion, other: Motion, spread: tuple[Floats, Floats]) -> tuple[float, float] | None:
    """Return the lag of the other where most of it repeats, and the time that repeats, s."""
    rate = min(SEARCHED, _MOST / max(len(one) / rate_of(one), len(other) / rate_of(other)))
    a, b = thinned(one, rate), thinned(other, rate)
    rate = rate_of(a)
    if abs(rate_of(b) / rate - 1) > 0.02 or len(a) < 2 or len(b) < 2:
        return None
    same = np.ones((len(a), len(b)), dtype=bool)
    for size, x, y in ((spread[0], a.q, b.q), (spread[1], a.qd, b.qd)):
        for n in range(len(size)):
            same &= np.abs(x[:, n, None] - y[None, :, n]) < _CLOSE * size[n]
    moving: Flags = np.any(np.abs(a.qd) > _MOVING * spread[1], axis=1)
    same &= moving[:, None]
    i, j = np.nonzero(same)
    offset = np.round((b.time[j] - a.time[i]) * rate).astype(np.int64)
    if one is other:
        offset = offset[offset > _APART * rate]
    if not offset.size:
        return None
    offsets, counts = np.unique(offset, return_counts=True)
    k = int(np.argmax(counts))
    if counts[k] < LEAST * rate:
        return None
    return float(offsets[k]) / rate, float(counts[k]) / rate


def _floor(
    case: Case, other: Motion, lag: float, spread: tuple[Floats, Floats]
) -> tuple[Floats, float] | None:
    """Return the noise (N,) in N·m of one repeat, and the time in s that was compared.

    The model's prediction for the small difference of the two motions is taken off.
    """
    this = case.thin
    lags = lag + np.linspace(-_AROUND, _AROUND, 61)
    lag = float(lags[int(np.argmin([_apart(this, other, at, spread[0]) for at in lags]))])
    fine = lag + np.linspace(-0.005, 0.005, 21)
    lag = float(fine[int(np.argmin([_apart(this, other, at, spread[0]) for at in fine]))])
    inside, at = _common(this, other, lag)
    if not inside.any():
        return None
    time = this.time[inside] + lag
    state = {name: _at(other, at, time, getattr(other, name)) for name in ("q", "qd", "qdd", "tau")}
    same = np.all(np.abs(state["q"] - this.q[inside]) < _SAME * spread[0], axis=1)
    same &= np.all(np.abs(state["qd"] - this.qd[inside]) < 2 * _SAME * spread[1], axis=1)
    same &= np.any(np.abs(this.qd[inside]) > _MOVING * spread[1], axis=1)
    seconds = float(same.sum()) / rate_of(this)
    if seconds < 0.5 * LEAST:
        return None
    predicted = case.model.predict(state["q"], state["qd"], state["qdd"])
    again = case.model.predict(this.q[inside], this.qd[inside], this.qdd[inside])
    difference = (state["tau"] - predicted) - (this.tau[inside] - again)
    return np.sqrt((difference[same] ** 2).mean(axis=0) / 2.0), seconds


def _common(this: Motion, other: Motion, lag: float) -> tuple[Flags, Ints]:
    """Return the samples whose lagged time the other has without a gap, and where there."""
    time = this.time + lag
    at = np.clip(np.searchsorted(other.time, time), 1, len(other) - 1)
    inside = (time >= other.time[0]) & (time <= other.time[-1])
    inside &= other.segment[at] == other.segment[at - 1]
    return inside, at[inside]


def _at(other: Motion, at: Ints, time: Floats, values: Floats) -> Floats:
    """Return (K, N) values between the samples, on straight lines."""
    before, after = other.time[at - 1], other.time[at]
    share = ((time - before) / np.maximum(after - before, 1e-12))[:, None]
    return np.asarray(values[at - 1] + share * (values[at] - values[at - 1]))


def _apart(this: Motion, other: Motion, lag: float, spread: Floats) -> float:
    """Return the median distance of the positions at a lag."""
    inside, at = _common(this, other, lag)
    if inside.sum() < 10:
        return np.inf
    q = _at(other, at, this.time[inside] + lag, other.q)
    return float(np.median(np.abs(q - this.q[inside]).max(axis=1, initial=0.0) / spread.max()))
