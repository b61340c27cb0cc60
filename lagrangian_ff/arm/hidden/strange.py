"""Physics that no catalogue of effects has; a diagnosis must not give it a known name."""

from math import cos, exp, pi, sin

import numpy as np

from lagrangian_ff.arm.hidden.base import (
    ALL_JOINTS,
    Installed,
    Law,
    OneJoint,
    Site,
    dry,
    partner,
    recorded,
    rub,
)
from lagrangian_ff.arm.joint_effect import JointMoment
from lagrangian_ff.arrays import Floats


def pitting(site: Site, strength: float) -> Installed:
    """Install friction of strength N·m within about 0.15 rad of an angle: a damaged bearing.

    The angle is in the middle half of the run's range.
    """
    joint = site.joint
    low, high = np.quantile(site.along.q[:, joint], (0.25, 0.75))
    centre = float(site.random.uniform(low, high))

    def law(v: float, moment: JointMoment) -> tuple[float, float]:
        x = (float(moment.q[joint]) - centre) / 0.15
        return rub(strength * exp(-0.5 * x * x) if abs(x) < 6.0 else 0.0, v)

    return Installed((Law(joint, law),), facts={"height [N·m]": strength, "angle [rad]": centre})


def shaking(site: Site, strength: float) -> Installed:
    """Install a torque of strength N·m at 2 to 5 Hz, whatever the arm does: the floor shakes.

    The phase is random in each recording.
    """
    frequency = site.random.uniform(2.0, 5.0)
    pace, phase = 2.0 * pi * frequency, site.events.uniform(0.0, 2.0 * pi)

    def law(v: float, moment: JointMoment) -> tuple[float, float]:
        return strength * sin(pace * moment.time + phase), 0.0

    facts = {"height [N·m]": strength, "frequency [Hz]": frequency}
    return Installed((Law(site.joint, law),), facts=facts)


def capstan(site: Site, strength: float) -> Installed:
    """Install friction of grip strength N·m: a hose around two joints that are turned apart.

    T (1 − cos(1.6 (q_j − q_k) + phase)) sign(qd_j): the tension of the hose sets the friction.
    """
    joint, other = site.joint, partner(site.joint)
    phase = site.random.uniform(0.0, 2.0 * pi)

    def law(v: float, moment: JointMoment) -> tuple[float, float]:
        apart = 1.6 * float(moment.q[joint] - moment.q[other]) + phase
        return rub(strength * (1.0 - cos(apart)), v)

    return Installed((Law(joint, law),), facts={"grip [N·m]": strength, "phase [rad]": phase})


def pinched(site: Site, strength: float) -> Installed:
    """Install friction of strength N·m that the angle of another joint sets: a pinched cable.

    F (1 + tanh((q_k − q0) / 0.2)) / 2 sign(qd_j), q0 in the middle of the other joint's run.
    """
    other = partner(site.joint)
    low, high = np.quantile(site.along.q[:, other], (0.35, 0.65))
    edge = float(site.random.uniform(low, high))

    def law(v: float, moment: JointMoment) -> tuple[float, float]:
        closed = 0.5 + 0.5 * dry(float(moment.q[other]) - edge, 0.2)[0]
        return rub(strength * closed, v)

    facts = {"height [N·m]": strength, "angle of the other [rad]": edge}
    return Installed((Law(site.joint, law),), facts=facts)


def dress_pack(site: Site, strength: float) -> Installed:
    """Install a torque of strength N·m that the angles of three joints set: a bundle of hoses.

    a sin(q_j + φ1) sin(q_k + φ2) sin(q_m + φ3): no one and no two of the angles show it.
    """
    others = site.random.choice([n for n in ALL_JOINTS if n != site.joint], 2, replace=False)
    turned = [site.joint, *(int(n) for n in others)]
    middle = np.median(site.along.q[:, turned], axis=0)
    phase = (site.random.uniform(-0.5, 0.5, 3) - middle).tolist()

    def law(v: float, moment: JointMoment) -> tuple[float, float]:
        torque = strength
        for n, ahead in zip(turned, phase, strict=True):
            torque *= sin(float(moment.q[n]) + ahead)
        return torque, 0.0

    facts = {"height [N·m]": strength, "joint k": turned[1] + 1.0, "joint m": turned[2] + 1.0}
    return Installed((Law(site.joint, law),), facts=facts)


def debris(site: Site, strength: float) -> Installed:
    """Install friction of strength N·m in bursts at random times: chips in the gear.

    Bursts last 0.3 to 0.8 s, one about every 4 s, more often in a short run.
    """
    random, end = site.events, float(site.along.time[-1])
    pause = min(3.0, 0.1 * end)
    begins = np.cumsum(random.exponential(pause, size=round(end)) + 0.8)
    begins = begins[begins < end]
    ends = begins + random.uniform(0.3, 0.8, size=len(begins))

    def law(v: float, moment: JointMoment) -> tuple[float, float]:
        last = int(np.searchsorted(begins, recorded(moment))) - 1
        over = last < 0 or recorded(moment) > ends[last]
        return (0.0, 0.0) if over else rub(strength, v)

    facts = {"height [N·m]": strength, "bursts": float(len(begins))}
    return Installed((Law(site.joint, law),), facts=facts)


class Starved(OneJoint):
    """A film that hard acceleration squeezes out and time refills: dry friction with memory.

    dw/dt = |qdd_j| / a − w / T, friction F w sign(v).
    """

    def __init__(self, joint: int, height: float, scale: float, time: float) -> None:
        super().__init__(joint)
        self._height, self._scale, self._time = height, scale, time
        self.reset(np.zeros(0))

    def reset(self, q: Floats) -> None:
        self._worn, self._before = 0.0, 0.0

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        return rub(self._height * self._worn, v)

    def advance(self, moment: JointMoment) -> None:
        v = float(moment.qd[self.joint])
        squeezed = abs(v - self._before) / self._scale
        self._before = v
        self._worn += (squeezed - moment.dt * self._worn) / self._time


def starved(site: Site, strength: float) -> Installed:
    """Install friction of strength N·m after steady acceleration of the run's mean; T 1 to 3 s."""
    time = site.random.uniform(1.0, 3.0)
    scale = float(np.abs(site.along.qdd[:, site.joint]).mean())
    return Installed(
        (Starved(site.joint, strength, scale, time),),
        facts={"height [N·m]": strength, "refill [s]": time},
    )
