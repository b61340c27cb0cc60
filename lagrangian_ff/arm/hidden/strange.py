"""Physics that no catalogue of effects has: what a diagnosis must not give a known name."""

from math import cos, exp, pi, sin

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arm.hidden.base import Installed, OneJoint, Site, dry, partner, recorded
from lagrangian_ff.arm.joint_effect import JointMoment

Floats = NDArray[np.float64]


class Pitting(OneJoint):
    """A damaged spot of a bearing: more dry friction within about 0.15 rad of one angle."""

    def __init__(self, joint: int, height: float, centre: float) -> None:
        super().__init__(joint)
        self._height, self._centre = height, centre

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """See OneJoint."""
        x = (float(moment.q[self.joint]) - self._centre) / 0.15
        height = self._height * exp(-0.5 * x * x) if abs(x) < 6.0 else 0.0
        sign, chord = dry(v)
        return height * sign, height * chord


def pitting(site: Site, strength: float) -> Installed:
    """Of strength N·m, at an angle in the middle half of what the run visits."""
    low, high = np.quantile(site.along.q[:, site.joint], (0.25, 0.75))
    centre = float(site.random.uniform(low, high))
    return Installed(
        (Pitting(site.joint, strength, centre),),
        facts={"height [N·m]": strength, "angle [rad]": centre},
    )


class Shaking(OneJoint):
    """A machine beside the arm shakes its floor at one frequency, whatever the arm does."""

    def __init__(self, joint: int, height: float, frequency: float, phase: float) -> None:
        super().__init__(joint)
        self._height, self._pace, self._phase = height, 2.0 * pi * frequency, phase

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """See OneJoint."""
        return self._height * sin(self._pace * moment.time + self._phase), 0.0


def shaking(site: Site, strength: float) -> Installed:
    """Of strength N·m at 2 to 5 Hz; the phase is of chance in each recording."""
    frequency = site.random.uniform(2.0, 5.0)
    phase = site.events.uniform(0.0, 2.0 * pi)
    return Installed(
        (Shaking(site.joint, strength, frequency, phase),),
        facts={"height [N·m]": strength, "frequency [Hz]": frequency},
    )


class Capstan(OneJoint):
    """A hose led around two joints grips by how far they are turned against each other.

    T (1 − cos(q_j − q_k + phase)) sign(qd_j): the tension of the hose sets the friction.
    """

    def __init__(self, joint: int, other: int, grip: float, phase: float) -> None:
        super().__init__(joint)
        self._other, self._grip, self._phase = other, grip, phase

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """See OneJoint."""
        apart = 1.6 * float(moment.q[self.joint] - moment.q[self._other]) + self._phase
        height = self._grip * (1.0 - cos(apart))
        sign, chord = dry(v)
        return height * sign, height * chord


def capstan(site: Site, strength: float) -> Installed:
    """Of strength N·m."""
    phase = site.random.uniform(0.0, 2.0 * pi)
    return Installed(
        (Capstan(site.joint, partner(site.joint), strength, phase),),
        facts={"grip [N·m]": strength, "phase [rad]": phase},
    )


class Pinched(OneJoint):
    """A cable pinched by another joint: friction here that the angle there sets.

    F (1 + tanh((q_k − q0) / 0.2)) / 2 sign(qd_j).
    """

    def __init__(self, joint: int, other: int, height: float, edge: float) -> None:
        super().__init__(joint)
        self._other, self._height, self._edge = other, height, edge

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """See OneJoint."""
        closed = 0.5 + 0.5 * dry(float(moment.q[self._other]) - self._edge, 0.2)[0]
        sign, chord = dry(v)
        return self._height * closed * sign, self._height * closed * chord


def pinched(site: Site, strength: float) -> Installed:
    """Of strength N·m, beyond an angle near the middle of the other joint's motion."""
    other = partner(site.joint)
    low, high = np.quantile(site.along.q[:, other], (0.35, 0.65))
    edge = float(site.random.uniform(low, high))
    return Installed(
        (Pinched(site.joint, other, strength, edge),),
        facts={"height [N·m]": strength, "angle of the other [rad]": edge},
    )


class Debris(OneJoint):
    """Chips in the gear: dry friction in bursts, at times of chance."""

    def __init__(self, joint: int, height: float, begins: Floats, ends: Floats) -> None:
        super().__init__(joint)
        self._height, self._begins, self._ends = height, begins, ends

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """See OneJoint."""
        last = int(np.searchsorted(self._begins, recorded(moment))) - 1
        if last < 0 or recorded(moment) > self._ends[last]:
            return 0.0, 0.0
        sign, chord = dry(v)
        return self._height * sign, self._height * chord


def debris(site: Site, strength: float) -> Installed:
    """Of strength N·m for 0.3 to 0.8 s, about every 4 s, more often in a short run."""
    random, end = site.events, float(site.along.time[-1])
    pause = min(3.0, 0.1 * end)
    begins = np.cumsum(random.exponential(pause, size=round(end)) + 0.8)
    begins = begins[begins < end]
    ends = begins + random.uniform(0.3, 0.8, size=len(begins))
    return Installed(
        (Debris(site.joint, strength, begins, ends),),
        facts={"height [N·m]": strength, "bursts": float(len(begins))},
    )


class Starved(OneJoint):
    """A film that hard acceleration squeezes out and time refills: dry friction with a memory.

    dw/dt = |qdd_j| / a − w / T, friction F w sign(v).
    """

    def __init__(self, joint: int, height: float, scale: float, time: float) -> None:
        super().__init__(joint)
        self._height, self._scale, self._time = height, scale, time
        self.reset(np.zeros(0))

    def reset(self, q: Floats) -> None:
        """See JointEffect."""
        self._worn, self._before = 0.0, 0.0

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """See OneJoint."""
        sign, chord = dry(v)
        return self._height * self._worn * sign, self._height * self._worn * chord

    def advance(self, moment: JointMoment) -> None:
        """See JointEffect."""
        v = float(moment.qd[self.joint])
        squeezed = abs(v - self._before) / self._scale
        self._before = v
        self._worn += (squeezed - moment.dt * self._worn) / self._time


def starved(site: Site, strength: float) -> Installed:
    """Of strength N·m after steady acceleration as hard as the run's mean; T of 1 to 3 s."""
    time = site.random.uniform(1.0, 3.0)
    scale = float(np.abs(site.along.qdd[:, site.joint]).mean())
    return Installed(
        (Starved(site.joint, strength, scale, time),),
        facts={"height [N·m]": strength, "refill [s]": time},
    )
