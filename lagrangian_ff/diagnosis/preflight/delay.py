"""The check of a delay between torque and position.

Two looks must agree. The phase of the cross-spectrum of measured and predicted torque sees all of
the motion, but hysteresis and friction that falls with speed turn it too. These act after
reversals. Between reversals, with friction and hysteresis fitted beside it, a delay d leaves
-d dτ/dt of whatever makes the torque change; an elastic gear leaves something there too, but hardly
turns the phase.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.diagnosis.lag import late as in_words
from lagrangian_ff.diagnosis.preflight.base import Case, Check, rate_of
from lagrangian_ff.effects.reversals import before_reversal, since_reversal
from lagrangian_ff.sampling import stretches

WINDOW = 3.0
"""Length of the windows of the spectra, s; they overlap by half."""
BAND = (0.7, 10.0)
"""Frequencies looked at, Hz."""
COHERENT = 0.7
"""Least coherence of a frequency whose phase counts."""
CLEAR = 3.0
"""Least ratio of delay and error to report a late torque of one joint."""
CLEAR_EARLY = 6.0
"""The same for an early one: friction that falls with speed and ripple resemble it."""
CERTAIN = 9.0
"""Least ratio to believe the delay of one joint alone: a model that fits it badly is late there
too, by some ms at 3 to 6 times the error."""
TOGETHER, TOGETHER_CLEAR = 0.004, 4.0
"""Least delay in s, and least ratio, to believe a delay of all joints."""
AWAY = 0.1
"""s from a reversal, before and after, that the second look leaves out."""
ALIKE = 2.5
"""Standard deviations by which both looks may differ."""
SEEN = 3.0
"""Least ratio of delay and error between reversals."""
CREEPS = (0.03, 0.1, 0.3)
"""Speeds in rad/s over which friction falls."""
SLIPS = (0.003, 0.01, 0.03, 0.1)
"""Ways in rad on which hysteresis dies away after a reversal; those of gears are among them."""
_SHORTEST = 0.2  # s between two reversals
_FEWEST_STRETCHES = 8
_ROUNDING = 1e-8
_FLOOR = 0.0015  # s: what the model's own error makes of a delay on joints that have none
_FEWEST = 5  # windows, and frequencies


@dataclass(frozen=True)
class Late:
    """A delay of torque against position, s, and its error."""

    delay: float
    error: float

    def __str__(self) -> str:
        return f"{1e3 * self.delay:.1f} ± {1e3 * self.error:.1f} ms"

    @classmethod
    def of_all(cls, several: list["Late"]) -> "Late":
        """Return the mean; its error grows if they differ by more than theirs."""
        delay = np.array([one.delay for one in several])
        weight = np.array([one.error for one in several]) ** -2.0
        mean = float(weight @ delay / weight.sum())
        apart = float(weight @ (delay - mean) ** 2) / max(len(several) - 1, 1)
        return cls(mean, float(np.sqrt(max(1.0, apart) / weight.sum())))

    def backs(self, other: "Late") -> bool:
        """Return whether this delay is there, and about as long as another."""
        apart = abs(self.delay - other.delay) / np.hypot(self.error, other.error)
        return bool(abs(self.delay) > SEEN * self.error and apart < ALIKE)


def check_delay(case: Case) -> list[Check]:
    """Report by how much the measured torque lags behind the model's, if both looks agree.

    A delay d turns the phase of their cross-spectrum by -2 pi f d, whatever the gain. Friction
    and masses that are a little wrong turn it too, but not along a line through zero: how much
    the slope changes when the line need not go through zero is the error of d.
    """
    found = {n: one for n in range(len(case.joints)) if (one := _delay(case, n))}
    if not found:
        return []
    between = {n: one for n in found if (one := _between_reversals(case, n))}
    delay, error = (np.array([getattr(o, k) for o in found.values()]) for k in ("delay", "error"))
    weight = error**-2.0
    common = Late(float(weight @ delay / weight.sum()), float(weight.sum() ** -0.5))
    agree = np.mean(delay * np.sign(common.delay) > 0.5 * TOGETHER) > 0.5
    clear = abs(common.delay) > max(TOGETHER, TOGETHER_CLEAR * common.error)
    finding = f"no clear delay between torque and position ({common} over the joints"
    values = {"delay": common.delay, "error": common.error}
    if between:
        apart = Late.of_all(list(between.values()))
        finding += f"; {apart} between reversals"
        values |= {"between reversals": apart.delay, "error between reversals": apart.error}
    nothing = [Check("delay", None, f"{finding})", values=values)]
    if len(found) > 1 and agree and clear:
        return [_check(None, common)] if between and apart.backs(common) else nothing
    late = [
        _check(case.joints[n], one)
        for n, one in found.items()
        if one.delay > CLEAR * one.error or -one.delay > CLEAR_EARLY * one.error
        if n in between and between[n].backs(one)
    ]
    return late or nothing


def _check(joint: str | None, late: Late) -> Check:
    delay, error = late.delay, late.error
    certain = joint is None or abs(delay) > CERTAIN * error
    finding = in_words(joint or "every joint", delay, error)
    undone = "add the effect delay" if joint else "read it in step, see --effort-delay"
    advice = (
        "Look for a filter or a bus that only one of the two passes, and stamp both when they are "
        f"measured; or {undone}"
        if certain
        else "A model that fits this joint badly looks so as well: believe it if delay is found "
        "among the effects too"
    )
    return Check("delay", joint, finding, certain, advice, {"delay": delay, "error": error})


def _delay(case: Case, n: int) -> Late | None:
    """Return the delay of one joint by the phase; None if too little is coherent."""
    rate = rate_of(case.thin)
    size = round(WINDOW * rate)
    frequency = np.fft.rfftfreq(size, 1.0 / rate)
    expected = _spectra(case.predicted[:, n], case.thin.segment, size)
    measured = _spectra(np.sign(case.slope[n]) * case.thin.tau[:, n], case.thin.segment, size)
    if len(expected) < _FEWEST:
        return None
    cross = (measured * expected.conj()).sum(axis=0)
    power = (np.abs(expected) ** 2).sum(axis=0) * (np.abs(measured) ** 2).sum(axis=0)
    coherence = np.abs(cross) ** 2 / np.maximum(power, 1e-300) - 1.0 / len(expected)
    used = (frequency >= BAND[0]) & (frequency <= BAND[1]) & (coherence > COHERENT)
    if used.sum() < _FEWEST:
        return None
    omega, phase = 2 * np.pi * frequency[used], np.angle(cross[used])
    weight = coherence[used] / np.maximum(1.0 - coherence[used], 0.01)
    delay = -_slope(omega, phase, weight)
    with_offset = -_slope(omega, phase, weight, offset=True)
    return Late(delay, float(np.hypot(delay - with_offset, _FLOOR)))


def _between_reversals(case: Case, n: int) -> Late | None:
    """Return the delay of one joint by what is left between its reversals; None if they are short.

    Least squares of the residual on -dτ/dt beside friction, masses, a gain, elasticity and
    hysteresis; in each stretch less its own line over time. The error takes stretches as
    independent, not samples.
    """
    motion = case.thin
    time, q, qd, segment = motion.time, motion.q[:, n], motion.qd[:, n], motion.segment
    torque = case.predicted[:, n]
    error = np.sign(case.slope[n]) * motion.tau[:, n] - torque
    sign = np.sign(qd)
    turned = (np.diff(sign, prepend=0.0) != 0.0) | (np.diff(segment, prepend=-1) != 0)
    stretch = np.cumsum(turned) - 1
    way = np.abs(q - q[np.flatnonzero(turned)[stretch]])
    rate = _rate(torque, time, segment)
    columns = [-rate, torque, np.abs(torque) * sign, _rate(rate, time, segment)]
    columns += [qd, qd * np.abs(qd), *motion.qdd.T]
    columns += [sign * np.exp(-way / slip) for slip in SLIPS]
    columns += [sign * np.exp(-np.abs(qd) / creep) for creep in CREEPS]
    table = np.column_stack([error, *columns])
    pieces = []
    for rows in _stretches(np.where(_away(case, n), stretch, -1), time):
        line = np.stack([np.ones(len(rows)), time[rows] - time[rows].mean()], axis=1)
        line /= np.sqrt(np.sum(line**2, axis=0))
        pieces.append(table[rows] - line @ (line.T @ table[rows]))
    if len(pieces) < _FEWEST_STRETCHES:
        return None
    scale = np.sqrt(sum(np.sum(piece**2, axis=0) for piece in pieces))[1:]
    scale[scale == 0.0] = 1.0
    columns_of = [piece[:, 1:] / scale for piece in pieces]
    inverse = np.linalg.pinv(sum(x.T @ x for x in columns_of), rcond=_ROUNDING, hermitian=True)
    pairs = list(zip(pieces, columns_of, strict=True))
    found = inverse @ sum(x.T @ piece[:, 0] for piece, x in pairs)
    scatter = sum(float(inverse[0] @ x.T @ (p[:, 0] - x @ found)) ** 2 for p, x in pairs)
    scatter *= len(pieces) / (len(pieces) - 1)
    return Late(float(found[0] / scale[0]), float(np.sqrt(scatter) / scale[0] + _ROUNDING))


def _away(case: Case, n: int) -> Flags:
    """Return whether each sample is far enough from the joint's reversals and the ends, (M,)."""
    motion = case.thin
    parts = motion.time, motion.qd[:, n], motion.segment
    since, before = since_reversal(*parts, rest=0.0), before_reversal(*parts)
    away = ~(since <= AWAY) & ~(before <= AWAY)
    for begin, end in stretches(motion.segment):
        ends = motion.time[begin:end]
        away[begin:end] &= (ends - ends[0] > 0.5 * AWAY) & (ends[-1] - ends > 0.5 * AWAY)
    return np.asarray(away)


def _stretches(number: Ints, time: Floats) -> list[Ints]:
    """Return the samples of each stretch of equal numbers that is long enough; -1 is none."""
    cuts = np.flatnonzero(np.diff(number, prepend=-2, append=-2))
    rows = [np.arange(a, b) for a, b in pairwise(cuts.tolist()) if number[a] >= 0]
    return [one for one in rows if time[one[-1]] - time[one[0]] >= _SHORTEST]


def _rate(values: Floats, time: Floats, segment: Ints) -> Floats:
    """Return the rate of change of (M,) values per s, never across a segment."""
    out = np.zeros_like(values)
    for begin, end in stretches(segment):
        if end - begin > 1:
            out[begin:end] = np.gradient(values[begin:end], time[begin:end])
    return out


def _slope(omega: Floats, phase: Floats, weight: Floats, offset: bool = False) -> float:
    """Return the slope of the line through the phases, and through zero without an offset."""
    if offset:
        omega = omega - weight @ omega / weight.sum()
    return float(weight @ (omega * phase) / (weight @ omega**2))


def _spectra(values: Floats, segment: Ints, size: int) -> NDArray[np.complex128]:
    """Return (K, F) spectra of windows that lie within a segment, half overlapping."""
    window, step = np.hanning(size), max(1, size // 2)
    starts = [
        k for k in range(0, len(values) - size + 1, step) if segment[k] == segment[k + size - 1]
    ]
    cut = [values[k : k + size] - values[k : k + size].mean() for k in starts]
    return np.asarray([np.fft.rfft(window * one) for one in cut], dtype=np.complex128)
