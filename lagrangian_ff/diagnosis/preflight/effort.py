"""Checks of the effort: its unit, its sign, and a limit that cuts it."""

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis.preflight.base import Case, Check, rate_of

SERIOUS = 1.5
"""Factor between measured and expected torque, either way, that no missing effect explains."""
NOTED = 1.2
_ALIKE = 1.15  # how far the joints' factors may be apart to be one

UNITS = {
    1000.0: "N·mm or mN·m",
    100.0: "N·cm",
    10.197: "kgf·cm",
    8.851: "lbf·in",
    0.7376: "lbf·ft",
    0.10197: "kgf·m",
    0.001: "kN·m",
}
"""By their number in one N·m."""
_SAME_UNIT = 1.06

# A limit that cuts the torque.
SHARE = 0.002
"""Least share of the time at the limit."""
PILED = 0.7
"""Least share of the highest four bands' samples in one of them: a round peak has half of it."""
FLAT = 0.004
"""Share of the extreme value: a torque that changes less stands still."""
LONG = 0.04
"""Least s of standing still: the filter's own time."""
VARIES = 0.025
"""Share of the extreme value by which the model's torque must change meanwhile."""
_RINGING = 0.06  # of the extreme: how far the low-pass swings beyond a clipped edge
_BAND = 0.006  # of the torque's range above its median, at least
_NOISE = 4.0  # times the noise, at least
_OVERSHOOT = 0.1  # of that range: how far noise and the low-pass swing beyond a clipped edge
_FEWEST = 8  # samples
_MOVED = 0.02  # of the top speed: what the joint must move
_FLAT = 1.5  # times the spread of the torque there: what the model's must vary
_LEVELS = 60  # that are tried


def check_unit(case: Case) -> list[Check]:
    """Report the ratio of measured and predicted torque, where the two follow each other."""
    clear = np.flatnonzero(case.clear & (case.slope > 0.0))
    if not clear.size:
        finding = (
            "on no joint does the measured torque follow the model closely enough to tell whether "
            "it is in N·m"
        )
        return [Check("effort unit", None, finding)]
    factor = case.slope[clear]
    common = float(np.exp(np.median(np.log(factor))))
    alike = clear.size >= 2 and bool(np.all(np.abs(np.log(factor / common)) < np.log(_ALIKE)))
    if alike and _off(common) >= SERIOUS:
        return [_all(case, common)]
    found = [_one(case, int(n)) for n in clear if _off(case.slope[n]) >= NOTED]
    low, high = float(factor.min()), float(factor.max())
    finding = f"the measured torque is {low:.2f} to {high:.2f} times the model's: the same unit"
    return found or [Check("effort unit", None, finding, values={"lowest": low, "highest": high})]


def check_sign(case: Case) -> list[Check]:
    """Report joints whose measured torque falls where the model's rises."""
    turned = np.flatnonzero(case.clear & (case.slope < 0.0)).tolist()
    if len(turned) == len(case.joints):
        flips = " ".join(_scale(case, joint, -1.0) for joint in case.joints)
        finding = "the effort of every joint has the sign opposite to the model's"
        advice = (
            f"Give --effort-scale {flips}, or correct the driver: effort is the torque that the "
            "motor puts on the joint"
        )
        values = {"correlation": float(case.correlation.max())}
        return [Check("effort sign", None, finding, True, advice, values)]
    found = []
    for n in turned:
        name, correlation = case.joints[n], case.correlation[n]
        finding = (
            f"the effort of {name} has the sign opposite to the model's (correlation "
            f"{correlation:.2f})"
        )
        advice = f"Give --effort-scale {_scale(case, name, -1.0)}, or correct the driver"
        values = {"correlation": correlation, "factor": case.slope[n]}
        found.append(Check("effort sign", name, finding, True, advice, values))
    return found


def _off(factor: float) -> float:
    return float(max(factor, 1.0 / factor))


def _scale(case: Case, joint: str, factor: float) -> str:
    """Return the option that undoes a factor, on top of the scale used to read the recording."""
    given = case.motion.conditioning.get("effort_scale")
    known = given.get(joint, 1.0) if isinstance(given, dict) else 1.0
    return f"{joint}={known / factor:.4g}"


def _all(case: Case, factor: float) -> Check:
    unit = next((name for number, name in UNITS.items() if _off(factor / number) < _SAME_UNIT), "")
    guess = f"it seems to be in {unit}" if unit else "it is in another unit, or a motor current"
    finding = f"the effort of every joint is {factor:.4g} of what the model expects: {guess}"
    scales = " ".join(_scale(case, name, factor) for name in case.joints)
    advice = f"Record effort in N·m, or give --effort-scale {scales}"
    return Check("effort unit", None, finding, True, advice, {"factor": factor})


def _one(case: Case, n: int) -> Check:
    name, factor = case.joints[n], float(case.slope[n])
    finding = f"the effort of {name} is {factor:.2f} of what the model expects"
    values = {"factor": factor, "correlation": case.correlation[n]}
    if _off(factor) >= SERIOUS:
        finding += ": other unit, gear ratio or torque constant?"
        advice = f"Check the driver's scale; --effort-scale {_scale(case, name, factor)} undoes it"
        return Check("effort unit", name, finding, True, advice, values)
    advice = "A wrong torque constant, a changed load or a missing effect may do this"
    return Check("effort unit", name, finding, False, advice, values)


def check_saturation(case: Case) -> list[Check]:
    """Report a measured torque that stays at its largest or smallest value."""
    advice = (
        "Repeat the motion slower or without payload, so that no torque reaches the limit; or add "
        "the effect saturation"
    )
    found = []
    for n, name in enumerate(case.joints):
        for sign in (1.0, -1.0):
            rest = _flat(case, n, sign) or _piled_up(case, n, sign)
            if rest is None:
                continue
            level, share, first = rest
            finding = (
                f"the effort of {name} rests at {level:.4g} N·m for {share:.1%} of the time, "
                f"first at {first:.2f} s: a limit cuts it"
            )
            values = {"level": level, "share": share, "first": first}
            found.append(Check("saturation", name, finding, True, advice, values))
    return found


def _flat(case: Case, n: int, sign: float) -> tuple[float, float, float] | None:
    """Return level, share of the time and first time of a noiseless torque that stands still."""
    motion = case.motion
    tau = sign * motion.tau[:, n]
    top, middle = float(tau.max()), float(np.median(tau))
    room = top - middle
    near = np.flatnonzero(tau > top - _RINGING * room)
    if room <= 0.0 or not near.size:
        return None
    # Runs of samples that lie within FLAT of the value in their middle.
    runs = _runs(tau, near, FLAT * room)
    moving = _MOVED * float(np.abs(motion.qd[:, n]).max())
    long = []
    for begin, end in runs:
        seconds = float(motion.time[end] - motion.time[begin])
        whole = motion.segment[begin] == motion.segment[end]
        if whole and seconds >= LONG and np.abs(motion.qd[begin : end + 1, n]).max() > moving:
            long.append((begin, end, float(np.median(tau[begin : end + 1]))))
    if not long:
        return None
    # A limit is one level: that at which it rests longest.
    level = max(long, key=lambda run: run[1] - run[0])[2]
    same = [(a, b) for a, b, value in long if abs(value - level) <= 2 * FLAT * room]
    samples = sum(b - a + 1 for a, b in same)
    if samples < SHARE * len(tau) or not _unusual(tau, level, samples, FLAT * room):
        return None
    expected = np.interp(motion.time, case.thin.time, case.slope[n] * case.predicted[:, n])
    if np.mean([np.ptp(expected[a : b + 1]) for a, b in same]) < VARIES * room:
        # The model's torque rests there too: a slow round peak.
        return None
    return sign * level, samples / len(tau), float(motion.time[same[0][0]])


def _runs(tau: Floats, near: Ints, width: float) -> list[tuple[int, int]]:
    """Return the first and last samples of stretches near the top that stay within a width."""
    runs = []
    begin = last = int(near[0])
    low = high = float(tau[begin])
    for k in near[1:].tolist():
        value = float(tau[k])
        low, high = min(low, value), max(high, value)
        if k != last + 1 or high - low > width:
            runs.append((begin, last))
            begin, low, high = k, value, value
        last = k
    runs.append((begin, last))
    return runs


def _unusual(tau: Floats, level: float, samples: int, width: float) -> bool:
    """Return whether far more samples lie at the level than in bands as wide below it."""
    below = [
        np.count_nonzero((tau > level - (k + 1.5) * width) & (tau <= level - (k + 0.5) * width))
        for k in range(1, 5)
    ]
    return samples > 4 * max(1.0, float(np.mean(below)))


def _piled_up(case: Case, n: int, sign: float) -> tuple[float, float, float] | None:
    """Return the same of a noisy torque: it piles up in a band as wide as its noise."""
    motion = case.thin
    speed = np.abs(motion.qd[:, n])
    moving = speed > _MOVED * float(speed.max())
    tau = sign * motion.tau[:, n]
    if moving.sum() < 10 * _FEWEST:
        return None
    top, room = float(tau[moving].max()), float(np.ptp(tau[moving]))
    room = min(room, top - float(np.median(tau[moving])))
    if room <= 0.0:
        return None
    width = max(_BAND * room, _NOISE * _noise(tau, rate_of(motion)))
    level = _piled(np.sort(tau[moving]), top, room, width)
    if level is None:
        return None
    resting = moving & (np.abs(tau - level) <= 0.5 * width)
    stretches = np.count_nonzero(np.diff(resting.astype(np.int8)) == 1)
    if resting.sum() < 1.5 * LONG * rate_of(motion) * stretches:
        # Round peaks, if of one height.
        return None
    expected = case.slope[n] * case.predicted[resting, n]
    if float(np.std(expected)) < _FLAT * float(np.std(tau[resting])):
        return None
    level = float(np.median(tau[resting]))
    return sign * level, float(resting.mean()), float(motion.time[int(np.argmax(resting))])


def _piled(ordered: Floats, top: float, room: float, width: float) -> float | None:
    """Return the level whose band holds most of what lies above four bands below, if one does."""
    levels = np.linspace(top - _OVERSHOOT * room - width, top, _LEVELS)
    count = len(ordered)
    inside = np.searchsorted(ordered, levels + 0.5 * width, "right") - np.searchsorted(
        ordered, levels - 0.5 * width
    )
    above = count - np.searchsorted(ordered, levels - 3.5 * width)
    enough = inside >= max(_FEWEST, SHARE * count)
    if not enough.any():
        return None
    share = np.where(enough, inside / np.maximum(above, 1), 0.0)
    best = int(np.argmax(share))
    return float(levels[best]) if share[best] > PILED else None


def _noise(tau: Floats, rate: float) -> float:
    """Return the standard deviation in N·m within 20 ms, from third differences."""
    apart = max(1, round(0.02 * rate))
    third = np.diff(np.stack([tau[k * apart : len(tau) - (3 - k) * apart] for k in range(4)]), 3, 0)
    return float(1.4826 * np.median(np.abs(third)) / np.sqrt(20.0))
