"""Checks of the time, range and speeds that a recording covers."""

import numpy as np

from lagrangian_ff.diagnosis.preflight.base import MARGIN, Case, Check, duration_of, rate_of
from lagrangian_ff.kernels import States

SHORT = 20.0
"""Duration in s below which chance cannot be separated from cause."""
STILL = 1e-3
"""Range in rad, and speed in rad/s, below which a joint stands still."""
OUTSIDE = 0.25
"""Share of samples outside the model's range that makes this the cause of its error."""
SLOW, SLOW_SHARE = 0.05, 0.01
"""Speed in rad/s below which a joint creeps, and the least share of the time for it."""
FAST = 0.4
"""Least share of the speed that the model knows."""
_SAMPLED = 80.0  # Hz


def check_stamps(case: Case) -> list[Check]:
    """Report gaps, a low rate, and the notes of conditioning about the stamps."""
    found = []
    motion = case.motion
    pieces = len(np.unique(motion.segment))
    if pieces > 1:
        lost = float(motion.time[-1] - motion.time[0]) - duration_of(motion)
        finding = f"the recording is in {pieces} pieces; {lost:.2f} s between them are lost"
        advice = "Record again if the gaps fall where the error is"
        values: dict[str, float] = {"pieces": pieces, "lost": lost}
        found.append(Check("stamps", None, finding, advice=advice, values=values))
    rate = rate_of(motion)
    if rate < _SAMPLED:
        finding = (
            f"sampled at {rate:.0f} Hz: what happens within {2e3 / rate:.0f} ms, as at reversals, "
            "is blurred"
        )
        advice = "Record at 100 Hz or more"
        found.append(Check("stamps", None, finding, advice=advice, values={"rate": rate}))
    words = ("stamp", "interpolated")
    found += [Check("stamps", None, note) for note in motion.notes if any(w in note for w in words)]
    return found


def check_range(case: Case) -> list[Check]:
    """Report the share of the motion outside what the model was identified on."""
    motion = case.thin
    excess = case.model.range.excess(States.of(motion.q, motion.qd, motion.qdd))
    outside = excess > MARGIN
    share = float(outside.any(axis=1).mean())
    if share == 0.0:
        return []
    worst = case.joints[int(np.argmax(outside.mean(axis=0)))]
    finding = (
        f"{share:.1%} of the motion lies outside what the model was identified on, most of it by "
        f"{worst}: there the model guesses"
    )
    advice = (
        "Errors there show the model's reach, not a missing effect: identify from a motion "
        "that goes there, or record inside"
    )
    serious = share > OUTSIDE
    return [Check("range", None, finding, serious, advice if serious else "", {"share": share})]


def check_still(case: Case) -> list[Check]:
    """Report joints that do not move."""
    found = []
    for n in np.flatnonzero(np.ptp(case.motion.q, axis=0) < STILL).tolist():
        name = case.joints[n]
        finding = f"{name} stands still: no effect on it can be seen"
        advice = f"lagrangian_ff excite exciting --joint {name} makes it move"
        found.append(Check("still", name, finding, advice=advice))
    return found


def check_duration(case: Case) -> list[Check]:
    """Report a motion too short to separate chance from cause."""
    seconds = duration_of(case.motion)
    if seconds >= SHORT:
        return []
    finding = f"{seconds:.1f} s of motion: too short to tell chance from cause"
    advice = "Record a minute or more"
    return [Check("duration", None, finding, advice=advice, values={"seconds": seconds})]


def check_speeds(case: Case) -> list[Check]:
    """Report joints that never creep, or never run as fast as the model knows."""
    found = []
    for n, name in enumerate(case.joints):
        speed = np.abs(case.thin.qd[:, n])
        top, known = float(speed.max()), float(case.model.range.qd_max[n])
        if top < STILL:
            continue
        slow = float(((speed < SLOW) & (speed > STILL)).mean())
        values = {"slow": slow, "top": top}
        if slow < SLOW_SHARE:
            finding = (
                f"{name} is slower than {SLOW:g} rad/s for {slow:.1%} of the time only: the "
                "friction of creeping cannot be seen"
            )
            advice = f'lagrangian_ff excite "slow sweep" --joint {name}'
            found.append(Check("speeds", name, finding, advice=advice, values=values))
        if top < FAST * known:
            finding = (
                f"{name} never exceeds {top:.2f} rad/s, where the model knows {known:.2f} rad/s: "
                "what grows with speed can hardly be seen"
            )
            advice = f"lagrangian_ff excite speeds --joint {name}"
            found.append(Check("speeds", name, finding, advice=advice, values=values))
    return found
