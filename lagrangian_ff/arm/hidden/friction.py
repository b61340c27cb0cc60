"""Friction and ripple beyond B qd + F sign(qd): over speed, angle, warmth and load."""

from math import cos, exp, log10, pi

import numpy as np

from lagrangian_ff.arm.hidden.base import Installed, Law, OneJoint, Site, dry, rub
from lagrangian_ff.arm.joint_effect import JointMoment
from lagrangian_ff.arm.parameters import ArmParameters


def stribeck(site: Site, strength: float) -> Installed:
    """Install more friction of strength N·m at rest; v_s of 0.04 to 0.15 rad/s.

    Before the lubricant's film carries: F sign(v) / (1 + (v/v_s)²), a Lorentzian over speed (Hess
    and Soom, J. Tribology 112, 1990).
    """
    speed = 10.0 ** site.random.uniform(log10(0.04), log10(0.15))

    def law(v: float, moment: JointMoment) -> tuple[float, float]:
        return rub(strength / (1.0 + (v / speed) ** 2), v)

    facts = {"extra at rest [N·m]": strength, "Stribeck speed [rad/s]": speed}
    return Installed((Law(site.joint, law),), facts=facts)


def _drag(joint: int, drag: float, power: float) -> Law:
    """Return the drag of a fluid, K sign(v) |v|^p."""

    def law(v: float, moment: JointMoment) -> tuple[float, float]:
        # The root turns over within 1 mrad/s of rest, where it would be infinitely steep.
        chord = drag * (v * v + 1e-6) ** (0.5 * (power - 1.0))
        return chord * v, chord

    return Law(joint, law)


def quadratic_drag(site: Site, strength: float) -> Installed:
    """Install drag of strength N·m·s²/rad²: a fluid that churns (Reynolds)."""
    return Installed((_drag(site.joint, strength, 2.0),), facts={"drag [N·m·s²/rad²]": strength})


def power_law(site: Site, strength: float) -> Installed:
    """Install drag of strength N·m at 1 rad/s: thinning grease (Herschel-Bulkley), p 0.3 to 0.7."""
    power = site.random.uniform(0.3, 0.7)
    facts = {"drag at 1 rad/s [N·m]": strength, "power": power}
    return Installed((_drag(site.joint, strength, power),), facts=facts)


def asymmetric_viscous(site: Site, strength: float) -> Installed:
    """Install drag of strength N·m·s/rad in one of both directions: B max(v, 0).

    As of a seal's lip that is dragged open or shut (Armstrong-Hélouvry, Control of Machines with
    Friction, 1991).
    """
    way = float(site.random.choice((-1.0, 1.0)))

    def law(v: float, moment: JointMoment) -> tuple[float, float]:
        drag = strength if v * way > 0.0 else 0.0
        return drag * v, drag

    facts = {"drag [N·m·s/rad]": strength, "direction": way}
    return Installed((Law(site.joint, law),), facts=facts)


def position_friction(site: Site, strength: float) -> Installed:
    """Install dry friction with a swing of strength N·m once a turn: an eccentric bearing.

    F (c + cos(q + phase)) sign(v), c as large as the joint's own friction needs it to stay a loss;
    at a random phase.
    """
    joint, phase = site.joint, site.random.uniform(0.0, 2.0 * pi)
    least = max(0.0, strength - 0.9 * site.parameters.coulomb[joint])

    def law(v: float, moment: JointMoment) -> tuple[float, float]:
        height = least + strength * cos(float(moment.q[joint]) + phase)
        sign, chord = dry(v)
        # A negative part is only taken from the joint's own friction, whose slope prevails.
        return height * sign, max(height, 0.0) * chord

    return Installed((Law(joint, law),), facts={"swing [N·m]": strength, "phase [rad]": phase})


class ColdGrease(OneJoint):
    """Friction that falls while the drive warms up, from cold at the beginning of the recording.

    A thermal mass: dθ/dt = (h − θ) / T, heated at h = 0.7 by current and electronics and 0.3 by
    friction (1 its mean power); grease thins as e^(−2θ). After Bittencourt and Gunnarsson, J. Dyn.
    Sys. Meas. Control 134 (2012), with a time constant short enough for a minute of motion.
    """

    def __init__(
        self, joint: int, share: float, time: float, mean_power: float, parameters: ArmParameters
    ) -> None:
        super().__init__(joint)
        self._coulomb = share * parameters.coulomb[joint]
        self._viscous = share * parameters.viscous[joint]
        self._time, self._mean_power, self._share = time, mean_power, share
        self._warmth = 0.0

    def reset(self, q: np.ndarray) -> None:
        self._warmth = 0.0

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        chord = exp(-2.0 * self._warmth) * (self._coulomb * dry(v)[1] + self._viscous)
        return chord * v, chord

    def advance(self, moment: JointMoment) -> None:
        v = float(moment.qd[self.joint])
        power = (self._coulomb * dry(v)[0] + self._viscous * v) * v / self._share
        heating = 0.7 + 0.3 * power / self._mean_power
        self._warmth += moment.dt * (heating - self._warmth) / self._time


def warm_up(site: Site, strength: float) -> Installed:
    """Install friction of strength times the joint's own friction, cold; T of 10 to 30 s."""
    time = site.random.uniform(10.0, 30.0)
    parameters, v = site.parameters, site.along.qd[:, site.joint]
    own = parameters.coulomb[site.joint] * np.abs(v) + parameters.viscous[site.joint] * v**2
    return Installed(
        (ColdGrease(site.joint, strength, time, float(np.mean(own)), parameters),),
        facts={"share of own friction, cold": strength, "time constant [s]": time},
    )


def load_friction(site: Site, strength: float) -> Installed:
    """Install dry friction of strength times the load."""
    return _teeth(site, strength, viscous=False)


def load_viscous(site: Site, strength: float) -> Installed:
    """Install viscous friction of strength s/rad times the load."""
    return _teeth(site, strength, viscous=True)


def _teeth(site: Site, strength: float, *, viscous: bool) -> Installed:
    """Return teeth that the load presses together: μ |load| sign(v), or μ |load| v of lubricant.

    The load is the torque that went into the links in the step before (Wernholt and Gunnarsson;
    Hamon et al., IROS 2010, for friction that is proportional to load).
    """

    def law(v: float, moment: JointMoment) -> tuple[float, float]:
        pressed = strength * abs(float(moment.load[site.joint]))
        chord = pressed if viscous else pressed * dry(v)[1]
        return chord * v, chord

    unit = " [s/rad]" if viscous else ""
    return Installed((Law(site.joint, law),), facts={f"share of load{unit}": strength})


def ripple(site: Site, strength: float) -> Installed:
    """Install ripple of strength N·m."""
    return _ripple(site, strength, loaded=False)


def gear_mesh(site: Site, strength: float) -> Installed:
    """Install ripple of strength times the load."""
    return _ripple(site, strength, loaded=True)


def _ripple(site: Site, strength: float, *, loaded: bool) -> Installed:
    """Return teeth or poles k times a turn: A cos(k q + phase), A constant or A |load|.

    Cogging of poles against slots does not need a load; the error of meshing teeth scales with the
    torque they carry (Tuttle and Seering, IEEE Trans. Robotics and Automation 12, 1996).
    """
    random, joint = site.random, site.joint
    # Spread evenly over the ratios, 5 to 17 times a turn.
    harmonic = round(5.0 * (17.0 / 5.0) ** random.uniform())
    phase = random.uniform(0.0, 2.0 * pi)

    def law(v: float, moment: JointMoment) -> tuple[float, float]:
        wave = cos(harmonic * float(moment.q[joint]) + phase)
        carried = abs(float(moment.load[joint])) if loaded else 1.0
        return strength * carried * wave, 0.0

    facts = {
        "height, of the load" if loaded else "height [N·m]": strength,
        "times a turn": float(harmonic),
        "phase [rad]": phase,
    }
    return Installed((Law(joint, law),), facts=facts)
