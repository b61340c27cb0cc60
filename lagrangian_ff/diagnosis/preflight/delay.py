"""The check of a delay between torque and position."""

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis.preflight.base import Case, Check, rate_of

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
_FLOOR = 0.0015  # s: what the model's own error makes of a delay on joints that have none
_FEWEST = 5  # windows, and frequencies


def check_delay(case: Case) -> list[Check]:
    """Report by how much the measured torque lags behind the model's.

    A delay d turns the phase of their cross-spectrum by -2 pi f d, whatever the gain. Friction
    and masses that are a little wrong turn it too, but not along a line through zero: how much
    the slope changes when the line need not go through zero is the error of d.
    """
    found = {n: one for n in range(len(case.joints)) if (one := _delay(case, n))}
    if not found:
        return []
    delay, error = (np.array(values) for values in zip(*found.values(), strict=True))
    weight = error**-2.0
    common, scatter = float(weight @ delay / weight.sum()), float(weight.sum() ** -0.5)
    agree = np.mean(delay * np.sign(common) > 0.5 * TOGETHER) > 0.5
    if len(found) > 1 and agree and abs(common) > max(TOGETHER, TOGETHER_CLEAR * scatter):
        return [_check(None, common, scatter)]
    late = [
        _check(case.joints[n], d, e)
        for n, (d, e) in found.items()
        if d > CLEAR * e or -d > CLEAR_EARLY * e
    ]
    finding = (
        f"no clear delay between torque and position ({1e3 * common:.1f} ± {1e3 * scatter:.1f} ms "
        "over the joints)"
    )
    values = {"delay": common, "error": scatter}
    return late or [Check("delay", None, finding, values=values)]


def _check(joint: str | None, delay: float, error: float) -> Check:
    certain = joint is None or abs(delay) > CERTAIN * error
    which, other = ("torque", "position") if delay > 0 else ("position", "torque")
    finding = (
        f"the {which} of {joint or 'every joint'} comes {1e3 * abs(delay):.1f} ± "
        f"{1e3 * error:.1f} ms later than its {other}"
    )
    advice = (
        "Look for a filter or a bus that only one of the two passes, and stamp both when they are "
        "measured; or add the effect delay"
        if certain
        else "A model that fits this joint badly looks so as well: believe it if delay is found "
        "among the effects too"
    )
    return Check("delay", joint, finding, certain, advice, {"delay": delay, "error": error})


def _delay(case: Case, n: int) -> tuple[float, float] | None:
    """Return the delay of one joint and its error, s; None if too little is coherent."""
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
    return delay, float(np.hypot(delay - with_offset, _FLOOR))


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
