"""Solid contacts in the joints: bristles, a differential pair, springs, soft gears and play."""

from math import copysign, exp, log10

import numpy as np

from lagrangian_ff.arm.description import JOINTS
from lagrangian_ff.arm.hidden.base import (
    Installed,
    Law,
    OneJoint,
    Site,
    dry,
    partner,
    unexplained_by,
)
from lagrangian_ff.arm.joint_effect import JointEffect, JointMoment
from lagrangian_ff.arm.plant import Gear
from lagrangian_ff.arrays import Floats

WINDOW = 0.03  # s, over which the servo's noise is averaged out of a twist


class Bristles(OneJoint):
    """Contacts that bend before they slip: dz/dt = v − |v| z / z_s, torque F z / z_s.

    Dahl's model (1968), the LuGre model without its speed dependence, solved exactly over a step
    of constant velocity: z goes to z_s sign(v) as e^(−|v| t / z_s).
    """

    def __init__(self, joint: int, slip: float, distance: float) -> None:
        super().__init__(joint)
        self._slip, self._distance = slip, distance
        self._bent = 0.0

    def reset(self, q: Floats) -> None:
        self._bent = 0.0

    def _after(self, v: float, dt: float) -> tuple[float, float]:
        """Return the bend, relative to z_s, after a step, and its derivative by v."""
        end = copysign(1.0, v)
        left = exp(-abs(v) * dt / self._distance)
        bent = end + (self._bent - end) * left
        return bent, (1.0 - end * self._bent) * left * dt / self._distance

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        bent, slope = self._after(v, moment.dt)
        return self._slip * bent, self._slip * slope

    def advance(self, moment: JointMoment) -> None:
        self._bent = self._after(float(moment.qd[self.joint]), moment.dt)[0]


def hysteresis(site: Site, strength: float) -> Installed:
    """Install bristles of strength N·m of slip; a presliding distance of 2 to 10 mrad."""
    distance = 10.0 ** site.random.uniform(log10(2e-3), -2.0)
    return Installed(
        (Bristles(site.joint, strength, distance),),
        facts={"slip torque [N·m]": strength, "presliding distance [rad]": distance},
    )


class Differential(JointEffect):
    """A bevel gear between two motors rubs at qd_j ± qd_k, and by virtual work brakes both.

    F sign(v_m) + B v_m on the first joint, the same times ±1 on the second.
    """

    def __init__(self, first: int, second: int, way: float, dry: float, viscous: float) -> None:
        self._row = np.zeros(len(JOINTS))
        self._row[first], self._row[second] = 1.0, way
        # The sum over both joints is bounded by twice the chord on each: the iteration is safe.
        self._bound = 2.0 * np.abs(self._row)
        self._dry, self._viscous = dry, viscous

    def torque(self, moment: JointMoment) -> tuple[Floats, Floats]:
        v = float(self._row @ moment.qd)
        chord = self._dry * dry(v)[1] + self._viscous
        return self._row * (chord * v), self._bound * chord


def coupled(site: Site, strength: float) -> Installed:
    """Install friction of strength N·m between a joint and its partner."""
    second = partner(site.joint)
    way = float(site.random.choice((-1.0, 1.0)))
    return Installed(
        (Differential(site.joint, second, way, strength, 0.3 * strength),),
        facts={"dry [N·m]": strength, "viscous [N·m·s/rad]": 0.3 * strength, "sign": way},
    )


def spring(site: Site, strength: float) -> Installed:
    """Install a hose or cable that is twisted: k x + k₃ x³ with x = q − q0, k of strength N·m/rad.

    k₃ is 0.3 k per rad²; q0 is within 0.5 rad of zero.
    """
    joint, cubic, rest = site.joint, 0.3 * strength, site.random.uniform(-0.5, 0.5)

    def law(v: float, moment: JointMoment) -> tuple[float, float]:
        x = float(moment.q[joint]) - rest
        return (strength + cubic * x * x) * x, 0.0

    return Installed(
        (Law(joint, law),), facts={"stiffness [N·m/rad]": strength, "rest [rad]": rest}
    )


def elasticity(site: Site, strength: float) -> Installed:
    """Install a gear that the run's RMS torque twists by strength rad; 4 % of critical damping."""
    torque = float(site.along.rms(site.along.motor)[site.joint])
    return _gear(site, torque / strength, 0.04, 0.0)


def backlash(site: Site, strength: float) -> Installed:
    """Install a play of strength rad; teeth that ring at 15 Hz with 40 % of critical damping."""
    inertia = float(site.parameters.reflected_inertia[site.joint])
    return _gear(site, inertia * (2.0 * np.pi * 15.0) ** 2, 0.4, strength)


def _gear(site: Site, stiffness: float, damping: float, play: float) -> Installed:
    inertia = float(site.parameters.reflected_inertia[site.joint])
    loss = 2.0 * damping * float(np.sqrt(stiffness * inertia))
    facts = {
        "stiffness [N·m/rad]": stiffness,
        "damping [N·m·s/rad]": loss,
        "play [rad]": play,
        "rotor against the link held [Hz]": float(np.sqrt(stiffness / inertia)) / (2.0 * np.pi),
    }
    return Installed(gears=(Gear(site.joint, stiffness, loss, play),), facts=facts)


def elasticity_torque(installed: Installed, site: Site) -> Floats:
    """Return the torque of the twist; along a stiff run the motor is load / stiffness ahead."""
    (gear,) = installed.gears
    return _twisted(site, gear.joint, site.along.load[:, gear.joint] / gear.stiffness)


def backlash_torque(installed: Installed, site: Site) -> Floats:
    """Return the torque of the twist; along a stiff run half the play, to the load's side."""
    (gear,) = installed.gears
    load = site.along.load[:, gear.joint]
    side = np.tanh(load / (0.05 * np.sqrt(np.mean(load**2))))
    return _twisted(site, gear.joint, 0.5 * gear.play * side)


def _twisted(site: Site, joint: int, estimate: Floats) -> Floats:
    """Return the torque of links that move otherwise than their motors, which have the encoders."""
    run = site.along
    ahead = run.ahead[:, joint] if np.any(run.ahead[:, joint]) else estimate
    ahead = _smooth(ahead, round(WINDOW / run.dt))
    rate = np.gradient(ahead, run.dt)
    q, qd, qdd = run.q.copy(), run.qd.copy(), run.qdd.copy()
    q[:, joint] += ahead
    qd[:, joint] += rate
    qdd[:, joint] += np.gradient(rate, run.dt)
    return unexplained_by(site, q, qd, qdd, links=True)


def _smooth(values: Floats, width: int) -> Floats:
    """Return values averaged twice over a window, with constant ends."""
    for _ in range(2):
        padded = np.pad(values, (width // 2, width - 1 - width // 2), mode="edge")
        values = np.convolve(padded, np.full(width, 1.0 / width), mode="valid")
    return values
