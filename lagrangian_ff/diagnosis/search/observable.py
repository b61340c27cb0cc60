"""Which effects a motion could have shown, had they been there."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lagrangian_ff.diagnosis.search.candidates import HIDDEN_BY_DESIGN
from lagrangian_ff.diagnosis.search.forward import FLOOR, Search
from lagrangian_ff.diagnosis.search.gain import PRIOR_SHARE, Score
from lagrangian_ff.effects import EFFECTS

SIZE = 0.1
"""An effect of this share of a joint's torque is what a motion should show."""
STILL = 1e-3  # rad


@dataclass(frozen=True)
class NotObservable:
    """An effect that would have gone unseen.

    Attributes:
        effect, joint: which, where.
        reason: why.
        next_motion: what to do to see it.
    """

    effect: str
    joint: str
    reason: str
    next_motion: str


def expected_gain(score: Score) -> float:
    """Nats that the effect would gain, on average, at `SIZE` of the joint's torque."""
    information = score.information / score.inflation
    signal = float(np.trace(information)) / len(information) * (SIZE / PRIOR_SHARE) ** 2
    price = float(np.linalg.slogdet(np.eye(len(information)) + information)[1])
    return 0.5 * (signal - price)


def not_observable(found: Search, joints: Sequence[str]) -> tuple[NotObservable, ...]:
    """Effects by joint that this motion hides, joints that stand still first."""
    motion = found.ground.motion
    still = np.ptp(motion.q, axis=0) < STILL
    power: dict[tuple[str, int], float] = {}
    seen = {step.score.candidate.key for step in found.steps}
    for score in found.all:
        if score.candidate.named and score.candidate.key not in seen:
            key = score.candidate.key
            power[key] = max(power.get(key, -np.inf), expected_gain(score))
    missing = []
    for (name, joint), gain in power.items():
        effect = EFFECTS.get(name) or next(
            s.candidate.effect for s in found.all if s.candidate.key == (name, joint)
        )
        if still[joint]:
            reason = f"{joints[joint]} stands still"
        elif gain < FLOOR:
            reason = (
                f"at {SIZE:.0%} of the joint's torque it would gain {max(gain, 0.0):.1f} nats of "
                f"evidence, {FLOOR:g} are needed"
            )
        else:
            continue
        missing.append(NotObservable(name, joints[joint], reason, effect.next_motion))
    for name in sorted((HIDDEN_BY_DESIGN - {"payload"}) & set(EFFECTS)):
        effect = EFFECTS[name]
        missing.append(NotObservable(name, "all", effect.caution, effect.next_motion))
    return tuple(missing)
