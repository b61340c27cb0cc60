"""Friction that depends on speed, angle or warmth in ways that B qd + F sign(qd) does not."""

from math import cos, exp, log10, pi

import numpy as np

from lagrangian_ff.arm.hidden.base import Installed, OneJoint, Site, dry
from lagrangian_ff.arm.joint_effect import JointMoment
from lagrangian_ff.arm.parameters import ArmParameters


class Stribeck(OneJoint):
    """More friction near rest, before the lubricant's film carries: F sign(v) / (1 + (v/v_s)²).

    Hess and Soom, J. Tribology 112 (1990): a Lorentzian over speed.
    """

    def __init__(self, joint: int, extra: float, speed: float) -> None:
        super().__init__(joint)
        self._extra, self._speed = extra, speed

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """See OneJoint."""
        height = self._extra / (1.0 + (v / self._speed) ** 2)
        sign, chord = dry(v)
        return height * sign, height * chord


def stribeck(site: Site, strength: float) -> Installed:
    """Of strength N·m at rest; v_s of 0.04 to 0.15 rad/s."""
    speed = 10.0 ** site.random.uniform(log10(0.04), log10(0.15))
    return Installed(
        (Stribeck(site.joint, strength, speed),),
        facts={"extra at rest [N·m]": strength, "Stribeck speed [rad/s]": speed},
    )


class PowerDrag(OneJoint):
    """Drag of a fluid, K sign(v) |v|^p.

    p = 2 churns (Reynolds); 0.3 to 0.7 shears a grease that thins (Herschel-Bulkley).
    """

    def __init__(self, joint: int, drag: float, power: float) -> None:
        super().__init__(joint)
        self._drag, self._power = drag, power

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """See OneJoint."""
        # The root turns over within 1 mrad/s of rest, where it would be infinitely steep.
        chord = self._drag * (v * v + 1e-6) ** (0.5 * (self._power - 1.0))
        return chord * v, chord


def quadratic_drag(site: Site, strength: float) -> Installed:
    """Of strength N·m·s²/rad²."""
    return Installed(
        (PowerDrag(site.joint, strength, 2.0),), facts={"drag [N·m·s²/rad²]": strength}
    )


def power_law(site: Site, strength: float) -> Installed:
    """Of strength N·m at 1 rad/s; p of 0.3 to 0.7."""
    power = site.random.uniform(0.3, 0.7)
    return Installed(
        (PowerDrag(site.joint, strength, power),),
        facts={"drag at 1 rad/s [N·m]": strength, "power": power},
    )


class OneWayDrag(OneJoint):
    """Viscous loss in one direction, as of a seal's lip that is dragged open or shut: B max(v, 0).

    Armstrong-Hélouvry, Control of Machines with Friction (1991), finds such asymmetries.
    """

    def __init__(self, joint: int, drag: float, way: float) -> None:
        super().__init__(joint)
        self._drag, self._way = drag, way

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """See OneJoint."""
        drag = self._drag if v * self._way > 0.0 else 0.0
        return drag * v, drag


def asymmetric_viscous(site: Site, strength: float) -> Installed:
    """Of strength N·m·s/rad, in one of both directions."""
    way = float(site.random.choice((-1.0, 1.0)))
    return Installed(
        (OneWayDrag(site.joint, strength, way),),
        facts={"drag [N·m·s/rad]": strength, "direction": way},
    )


class TightSpot(OneJoint):
    """An eccentric bearing: dry friction that rises and falls once a turn of the joint.

    F (c + cos(q + phase)) sign(v), c as large as the joint's own friction needs it to stay a loss.
    """

    def __init__(self, joint: int, swing: float, phase: float) -> None:
        super().__init__(joint)
        self._swing, self._phase = swing, phase
        self._least = max(0.0, swing - 0.9 * ArmParameters().coulomb[joint])

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """See OneJoint."""
        height = self._least + self._swing * cos(float(moment.q[self.joint]) + self._phase)
        sign, chord = dry(v)
        # A negative part is only taken from the joint's own friction, whose slope prevails.
        return height * sign, max(height, 0.0) * chord


def position_friction(site: Site, strength: float) -> Installed:
    """Of strength N·m, at a random phase."""
    phase = site.random.uniform(0.0, 2.0 * pi)
    return Installed(
        (TightSpot(site.joint, strength, phase),),
        facts={"swing [N·m]": strength, "phase [rad]": phase},
    )


class ColdGrease(OneJoint):
    """Friction that falls while the drive warms up, from cold at the beginning of the recording.

    A thermal mass: dθ/dt = (h − θ) / T, heated at h = 0.7 by current and electronics and 0.3 by
    friction (1 its mean power); grease thins as e^(−2θ). After Bittencourt and Gunnarsson, J. Dyn.
    Sys. Meas. Control 134 (2012), with a time constant short enough for a minute of motion.
    """

    def __init__(self, joint: int, share: float, time: float, mean_power: float) -> None:
        super().__init__(joint)
        parameters = ArmParameters()
        self._coulomb = share * parameters.coulomb[joint]
        self._viscous = share * parameters.viscous[joint]
        self._time, self._mean_power, self._share = time, mean_power, share
        self._warmth = 0.0

    def reset(self, q: np.ndarray) -> None:
        """See JointEffect."""
        self._warmth = 0.0

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """See OneJoint."""
        chord = exp(-2.0 * self._warmth) * (self._coulomb * dry(v)[1] + self._viscous)
        return chord * v, chord

    def advance(self, moment: JointMoment) -> None:
        """See JointEffect."""
        v = float(moment.qd[self.joint])
        power = (self._coulomb * dry(v)[0] + self._viscous * v) * v / self._share
        heating = 0.7 + 0.3 * power / self._mean_power
        self._warmth += moment.dt * (heating - self._warmth) / self._time


def warm_up(site: Site, strength: float) -> Installed:
    """Of strength times the joint's own friction, cold; T of 10 to 30 s."""
    time = site.random.uniform(10.0, 30.0)
    parameters, v = ArmParameters(), site.along.qd[:, site.joint]
    own = parameters.coulomb[site.joint] * np.abs(v) + parameters.viscous[site.joint] * v**2
    return Installed(
        (ColdGrease(site.joint, strength, time, float(np.mean(own))),),
        facts={"share of own friction, cold": strength, "time constant [s]": time},
    )
