"""Which effects a motion shows, whether they are there or not: by the evidence to be expected."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.results import NotObservable
from lagrangian_ff.diagnosis.search.bayes_factor import BayesFactor
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.recording.motion import Motion

Clearest = Mapping[tuple[str, int], BayesFactor]
"""By effect and joint, the score whose shape the motion shows best."""


def clearest(scores: Iterable[BayesFactor]) -> Clearest:
    """Return of each effect and joint the score that is seen at the least size."""
    floor = thresholds.USED.floor
    best: dict[tuple[str, int], BayesFactor] = {}
    for score in scores:
        if score.candidate.named:
            mine = best.setdefault(score.candidate.key, score)
            if score.least_size(floor) < mine.least_size(floor):
                best[score.candidate.key] = score
    return best


def still(motion: Motion) -> list[bool]:
    """Return of each joint whether it stands still."""
    return [bool(one) for one in np.ptp(motion.q, axis=0) < thresholds.USED.still]


def hidden(best: Clearest, motion: Motion, joints: Sequence[str]) -> tuple[NotObservable, ...]:
    """Return the effects that a motion does not show at `observable_size` of a joint's torque.

    Args:
        best: of the candidates on this motion.  joints: N names.
    """
    limits, stands = thresholds.USED, still(motion)
    missing = []
    for (name, joint), score in best.items():
        gain = score.expected_gain(limits.observable_size)
        if stands[joint]:
            reason = f"{joints[joint]} stands still"
        elif gain < limits.floor:
            reason = (
                f"at {limits.observable_size:.0%} of the joint's torque it would gain "
                f"{max(gain, 0.0):.1f} nats of evidence, {limits.floor:g} are needed"
            )
        else:
            continue
        motion_to_do = score.candidate.effect.next_motion
        missing.append(NotObservable(name, joints[joint], reason, motion_to_do))
    for name in sorted(name for name, effect in EFFECTS.items() if not effect.observable):
        effect = EFFECTS[name]
        missing.append(NotObservable(name, "all", effect.caution, effect.next_motion))
    return tuple(missing)
