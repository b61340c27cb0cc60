"""What can the recording show at all?"""

import numpy as np

from lagrangian_ff.diagnosis.preflight.base import MARGIN, Case, Check, duration_of, rate_of
from lagrangian_ff.kernels import States

SHORT = 20.0
"""s"""
STILL = 1e-3
"""rad"""
OUTSIDE = 0.25
"""Share of the samples outside what the model knows from which on its error tells of that."""
SLOW, SLOW_SHARE = 0.05, 0.01
"""rad/s, and the share of the time that creeping must have."""
FAST = 0.4
"""Of the speed that the model knows."""
_SAMPLED = 80.0  # Hz


def check_stamps(case: Case) -> list[Check]:
    """Gaps, and what conditioning had to say about the stamps."""
    found = []
    motion = case.motion
    pieces = len(np.unique(motion.segment))
    if pieces > 1:
        lost = float(motion.time[-1] - motion.time[0]) - duration_of(motion)
        found.append(
            Check(
                "stamps",
                None,
                f"the recording is in {pieces} pieces; {lost:.2f} s between them are lost",
                advice="Record again if the gaps fall where the error is",
                values={"pieces": pieces, "lost": lost},
            )
        )
    rate = rate_of(motion)
    if rate < _SAMPLED:
        found.append(
            Check(
                "stamps",
                None,
                f"sampled at {rate:.0f} Hz: what happens within {2e3 / rate:.0f} ms, as at "
                "reversals, is blurred",
                advice="Record at 100 Hz or more",
                values={"rate": rate},
            )
        )
    words = ("stamp", "interpolated")
    found += [Check("stamps", None, note) for note in motion.notes if any(w in note for w in words)]
    return found


def check_range(case: Case) -> list[Check]:
    """How much of the motion lies outside what the model was identified on."""
    motion = case.thin
    excess = case.model.range.excess(States.of(motion.q, motion.qd, motion.qdd))
    outside = excess > MARGIN
    share = float(outside.any(axis=1).mean())
    if share == 0.0:
        return []
    worst = int(np.argmax(outside.mean(axis=0)))
    return [
        Check(
            "range",
            None,
            f"{share:.1%} of the motion lies outside what the model was identified on, most of it "
            f"by {case.joints[worst]}: there the model guesses",
            share > OUTSIDE,
            "Errors there tell of the model's reach, not of a missing effect: identify from a "
            "motion that goes there, or record inside"
            if share > OUTSIDE
            else "",
            {"share": share},
        )
    ]


def check_still(case: Case) -> list[Check]:
    """Joints that do not move."""
    still = np.flatnonzero(np.ptp(case.motion.q, axis=0) < STILL).tolist()
    return [
        Check(
            "still",
            case.joints[n],
            f"{case.joints[n]} stands still: no effect of its own can be seen",
            advice=f"lagrangian_ff excite exciting --joint {case.joints[n]} makes it move",
        )
        for n in still
    ]


def check_duration(case: Case) -> list[Check]:
    """Whether it is long enough to tell chance from cause."""
    seconds = duration_of(case.motion)
    if seconds >= SHORT:
        return []
    return [
        Check(
            "duration",
            None,
            f"{seconds:.1f} s of motion: too short to tell chance from cause",
            advice="Record a minute or more",
            values={"seconds": seconds},
        )
    ]


def check_speeds(case: Case) -> list[Check]:
    """Joints that never creep, or never run as fast as the model knows."""
    found = []
    for n, name in enumerate(case.joints):
        speed = np.abs(case.thin.qd[:, n])
        top, known = float(speed.max()), float(case.model.range.qd_max[n])
        if top < STILL:
            continue
        slow = float(((speed < SLOW) & (speed > 1e-3)).mean())
        if slow < SLOW_SHARE:
            found.append(
                Check(
                    "speeds",
                    name,
                    f"{name} is slower than {SLOW:g} rad/s for {slow:.1%} of the time only: the "
                    "friction of creeping cannot be seen",
                    advice=f'lagrangian_ff excite "slow sweep" --joint {name}',
                    values={"slow": slow, "top": top},
                )
            )
        if top < FAST * known:
            found.append(
                Check(
                    "speeds",
                    name,
                    f"{name} never exceeds {top:.2f} rad/s, where the model knows {known:.2f} "
                    "rad/s: what grows with speed can hardly be seen",
                    advice=f"lagrangian_ff excite speeds --joint {name}",
                    values={"slow": slow, "top": top},
                )
            )
    return found
