"""Random serial robots: their torques, how they are drawn, and samples to learn them from.

Every parameter is uniform in a bounded range, and every robot could be built. A link is given by
the second moments of its mass about its centre, along its own axes: where these are positive, its
inertia is positive definite and keeps the triangle inequality, as that of matter does. Lengths and
masses are those of an arm on a table; friction does not depend on the number of links that it
moves, as in section IV-A.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.kernels import States

Range = tuple[float, float]

GRAVITY = 9.81  # m/s²
OFFSET: Range = (-0.5, 0.5)  # m, along each axis
MASS: Range = (0.5, 5.0)  # kg
CENTRE: Range = (-0.3, 0.3)  # m, along each axis
SPREAD: Range = (0.05, 0.3)  # m, root of the mean squared distance of a link's mass from its centre
GEAR: Range = (10.0, 100.0)
MOTOR_INERTIA: Range = (1e-6, 2e-5)  # kg·m²
VISCOUS: Range = (0.0, 2.0)  # N·m·s/rad
COULOMB: Range = (0.0, 5.0)  # N·m
# q in rad, qd in rad/s and qdd in rad/s² reach from minus to plus these. With half a second for the
# unit of time both rates reach 1, as in section IV.
REACH = (np.pi, 2.0, 4.0)
AXIS = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Robot:
    """N links in a row; frame n stands on joint n, turns with link n, and its z is the axis.

    Attributes:
        rotation: (N, 3, 3) from frame n to the frame before it, at q = 0; the first is the base,
            whose z points up.
        offset: (N, 3) m, the origin of frame n in the frame before it.
        mass: (N,) kg.
        centre: (N, 3) m, of mass, in frame n.
        inertia: (N, 3, 3) kg·m², about the centre of mass.
        gear: (N,) turns of the motor for one of the joint.
        motor_inertia: (N,) kg·m², of the motor's rotor about its own axis.
        viscous: (N,) N·m·s/rad.
        coulomb: (N,) N·m.
    """

    rotation: Floats
    offset: Floats
    mass: Floats
    centre: Floats
    inertia: Floats
    gear: Floats
    motor_inertia: Floats
    viscous: Floats
    coulomb: Floats

    @property
    def joints(self) -> int:
        """Return the number of joints N."""
        return len(self.mass)

    @property
    def rotor(self) -> Floats:
        """Return the inertia (N,) in kg·m² of the motors' rotors at the joints."""
        return self.gear**2 * self.motor_inertia

    def torque(self, x: States) -> Floats:
        """Return the torque (M, N) in N·m that moves the links and the rotors, without friction."""
        return self._links(x) + self.rotor * x.qdd

    def friction(self, x: States) -> Floats:
        """Return the viscous and the Coulomb friction (M, N) in N·m, the latter a sharp sign."""
        return self.viscous * x.qd + self.coulomb * np.sign(x.qd)

    def _links(self, x: States) -> Floats:
        """Return the links' torque (M, N) in N·m by recursive Newton-Euler (Luh et al., 1980)."""
        count, joints = x.q.shape
        turned = [self.rotation[n] @ _rotations(x.q[:, n], 2) for n in range(joints)]
        # Outwards: angular velocity, its rate, and the acceleration of the origin, in frame n. A
        # base that accelerates upwards stands for gravity.
        spin, rate = np.zeros((count, 3)), np.zeros((count, 3))
        origin = np.tile(GRAVITY * AXIS, (count, 1))
        forces, moments = [], []
        for n in range(joints):
            own = AXIS * x.qd[:, [n]]
            origin = _into(turned[n], origin + _carried(spin, rate, self.offset[n]))
            before = _into(turned[n], spin)
            spin = before + own
            rate = _into(turned[n], rate) + np.cross(before, own) + AXIS * x.qdd[:, [n]]
            centre, inertia = self.centre[n], self.inertia[n]
            force = self.mass[n] * (origin + _carried(spin, rate, centre))
            forces.append(force)
            moments.append(
                rate @ inertia + np.cross(spin, spin @ inertia) + np.cross(centre, force)
            )
        # Inwards: what joint n hands on to the links beyond it.
        torque = np.empty((count, joints))
        force, moment = np.zeros((count, 3)), np.zeros((count, 3))
        for n in reversed(range(joints)):
            force, moment = force + forces[n], moment + moments[n]
            torque[:, n] = moment[:, 2]
            force, moment = _out_of(turned[n], force), _out_of(turned[n], moment)
            moment = moment + np.cross(self.offset[n], force)
        return torque


def _rotations(angle: Floats, axis: int) -> Floats:
    """Return rotations (M, 3, 3) by angles (M,) about an axis, 0 for x to 2 for z."""
    out = np.zeros((len(angle), 3, 3))
    first, second = (axis + 1) % 3, (axis + 2) % 3
    out[:, first, first] = out[:, second, second] = np.cos(angle)
    out[:, second, first] = np.sin(angle)
    out[:, first, second] = -out[:, second, first]
    out[:, axis, axis] = 1.0
    return out


def _carried(spin: Floats, rate: Floats, arm: Floats) -> Floats:
    """Return the acceleration (M, 3) of the end of an arm that its frame's turning causes."""
    return np.asarray(np.cross(rate, arm) + np.cross(spin, np.cross(spin, arm)))


def _into(turned: Floats, vectors: Floats) -> Floats:
    """Return vectors (M, 3) of the frame before in the turned frame."""
    return np.asarray(np.einsum("mji,mj->mi", turned, vectors))


def _out_of(turned: Floats, vectors: Floats) -> Floats:
    """Return vectors (M, 3) of the turned frame in the frame before."""
    return np.asarray(np.einsum("mij,mj->mi", turned, vectors))


class Chance(IntEnum):
    """Uses of random numbers: each has its own, so that a change leaves the others alone."""

    ROBOT = 0
    TRAINING = 1
    VALIDATION = 2
    NOISE = 3
    FOLDS = 4


def chance(seed: int, joints: int, number: int, what: Chance) -> np.random.Generator:
    """Return random numbers that depend on these arguments and on nothing else."""
    return np.random.default_rng([seed, joints, number, int(what)])


def draw_robot(seed: int, joints: int, number: int) -> Robot:
    """Return the robot of a number from 0 up, the same whatever the number of robots."""
    random = chance(seed, joints, number, Chance.ROBOT)
    mass = random.uniform(*MASS, joints)
    return Robot(
        # About x: the lean of each axis against the one before.
        rotation=_rotations(random.uniform(-np.pi, np.pi, joints), 0),
        offset=random.uniform(*OFFSET, (joints, 3)),
        mass=mass,
        centre=random.uniform(*CENTRE, (joints, 3)),
        inertia=mass[:, None, None] * np.array([_per_mass(random) for _ in range(joints)]),
        gear=random.uniform(*GEAR, joints),
        motor_inertia=random.uniform(*MOTOR_INERTIA, joints),
        viscous=random.uniform(*VISCOUS, joints),
        coulomb=random.uniform(*COULOMB, joints),
    )


def _per_mass(random: np.random.Generator) -> Floats:
    """Return inertia over mass (3, 3) in m², about the centre of a body that leans at random."""
    axes, _ = np.linalg.qr(random.normal(size=(3, 3)))
    moments = random.uniform(*SPREAD, 3) ** 2
    return np.asarray(axes @ np.diag(moments.sum() - moments) @ axes.T)


@dataclass(frozen=True)
class Scene:
    """The robots and samples that a study asks for.

    Attributes:
        training, validation: numbers of samples.
        folds: of cross-validation.
        friction: whether the robots have it.
        noise: standard deviation on training torques, in the unit of the samples.
    """

    training: int = 500
    validation: int = 15_000
    folds: int = 5
    friction: bool = False
    noise: float = 0.0


@dataclass(frozen=True)
class Samples:
    """Independent samples of one robot; torques in its unit.

    Attributes:
        unit: N·m, the largest torque without friction of all joints and training samples. All
            joints share it, so that their torques still derive from one Lagrangian.
        x: (M, N) training states.
        tau: (M, N) torques there, as measured with noise.
        friction: (M, N) friction in them; zero if the scene has none.
        fold: (M,) the fold of each training sample.
        asked: (V, N) validation states.
        truth: (V, N) torques there without noise, with friction if the scene has it.
        asked_friction: (V, N) friction there.
    """

    unit: float
    x: States
    tau: Floats
    friction: Floats
    fold: Ints
    asked: States
    truth: Floats
    asked_friction: Floats


def draw_samples(scene: Scene, seed: int, joints: int, number: int) -> Samples:
    """Return samples of the robot that `draw_robot` returns for a number."""
    robot = draw_robot(seed, joints, number)

    def some(count: int, what: Chance) -> States:
        random = chance(seed, joints, number, what)
        return States.of(*(random.uniform(-most, most, (count, joints)) for most in REACH))

    x, asked = some(scene.training, Chance.TRAINING), some(scene.validation, Chance.VALIDATION)
    ideal = robot.torque(x)
    unit = float(np.abs(ideal).max())
    size = float(scene.friction) / unit
    friction, asked_friction = size * robot.friction(x), size * robot.friction(asked)
    order = chance(seed, joints, number, Chance.FOLDS).permutation(scene.training)
    noise = scene.noise * chance(seed, joints, number, Chance.NOISE).normal(size=ideal.shape)
    return Samples(
        unit=unit,
        x=x,
        tau=ideal / unit + friction + noise,
        friction=friction,
        fold=order % scene.folds,
        asked=asked,
        truth=robot.torque(asked) / unit + asked_friction,
        asked_friction=asked_friction,
    )
