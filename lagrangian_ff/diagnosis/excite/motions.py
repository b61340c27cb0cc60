"""The motions, listed once by the names that effects give them."""

from collections.abc import Callable
from dataclasses import dataclass

from lagrangian_ff.diagnosis.excite import many_joints, one_joint
from lagrangian_ff.diagnosis.excite.path import REST, Path

Maker = Callable[[Path, int | None, float, int], None]
"""(path, joint, seconds, seed): appends the motion of a joint, None for all, to the path."""


@dataclass(frozen=True)
class NextMotion:
    """A motion that shows effects or tells look-alikes apart.

    Attributes:
        make: appends it to a path.
        seconds: how long it should last for one joint, or for all where all move at once.
        meaning: what it is and what it shows.
        one_each: whether all joints do it one after the other, half as long each.
        by_hand: what the user must do.
    """

    make: Maker
    seconds: float
    meaning: str
    one_each: bool = False
    by_hand: str = "Record joint states from a second before it begins to a second after its end."

    def usual(self, joints: int) -> float:
        """s that it should last for this many joints."""
        return self.seconds * max(1.0, 0.5 * joints) if self.one_each else self.seconds


def _each(one: Callable[[Path, int, float], None]) -> Maker:
    """The motion of one joint; for all, one after the other, each from the pose."""

    def make(path: Path, joint: int | None, seconds: float, seed: int) -> None:
        pose = path.at
        joints = many_joints.movable(path) if joint is None else [joint]
        for n in joints:
            one(path, n, seconds / len(joints))
            path.move(pose)
            path.rest(REST)

    return make


NEXT_MOTIONS: dict[str, NextMotion] = {
    "exciting": NextMotion(
        many_joints.exciting,
        60.0,
        "All joints swing through their ranges at once, slow and fast in turn. It shows inertia, "
        "gravity and their couplings, and is what a model is best identified from.",
    ),
    "speeds": NextMotion(
        _each(one_joint.speeds),
        60.0,
        "One joint runs both ways at constant speeds from creeping to its limit. It shows how "
        "friction depends on speed: viscous, quadratic, a power, unequal both ways.",
        one_each=True,
    ),
    "slow sweep": NextMotion(
        _each(one_joint.slow_sweep),
        60.0,
        "One joint goes slowly through its whole range and back, then creeps at 0.005 to "
        "0.15 rad/s. It shows what depends on position (ripple, springs, worn places) without "
        "inertia, and the friction of creeping.",
        one_each=True,
    ),
    "reversals": NextMotion(
        _each(one_joint.reversals),
        60.0,
        "One joint reverses again and again, with strokes of 0.1 mrad to 0.15 rad at two speeds. "
        "It tells dry friction, hysteresis before sliding and backlash apart.",
        one_each=True,
    ),
    "chirp": NextMotion(
        _each(one_joint.rising),
        40.0,
        "One joint trembles by a few mrad, from 0.3 to 10 Hz. It tells a delay (grows with the "
        "frequency) from elasticity (grows with its square).",
        one_each=True,
    ),
    "one by one": NextMotion(
        many_joints.one_by_one,
        80.0,
        "Each joint moves alone, then pairs of them, with and against each other. It shows "
        "friction in shared gears, which a joint alone cannot.",
    ),
    "warm-up": NextMotion(
        many_joints.warm_up,
        300.0,
        "The same short motion again and again. Friction changes as the gears get warm, gravity "
        "does not.",
        by_hand="Let the arm stand until it is cold, then record the whole motion without a pause.",
    ),
    "payloads": NextMotion(
        many_joints.payloads,
        60.0,
        "One motion to be done twice, at all speeds and with slow strokes. What follows the load "
        "differs between the two.",
        by_hand="Record it once as the arm is, then fix a payload of known mass to the last link "
        "and record it again: two recordings. Check before the second that the payload clears "
        "everything.",
    ),
}
"""Every motion by its name; the names are those of `lagrangian_ff.effects.MOTIONS`."""
