"""Drawing robots: every parameter uniform in a bounded range, every robot one that could be built.

A link is given by the second moments of its mass about its centre, along axes of its own. With
these positive its inertia is positive definite and keeps the triangle inequality, as that of matter
does. Lengths and masses are those of an arm on a table; friction does not know how many links it
moves, as in section IV-A.
"""

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.studies.robots.robot import Robot

Floats = NDArray[np.float64]
Range = tuple[float, float]

OFFSET: Range = (-0.5, 0.5)  # m, along each axis
MASS: Range = (0.5, 5.0)  # kg
CENTRE: Range = (-0.3, 0.3)  # m, along each axis
SPREAD: Range = (0.05, 0.3)  # m, root of the mean squared distance of a link's mass from its centre
GEAR: Range = (10.0, 100.0)
MOTOR_INERTIA: Range = (1e-6, 2e-5)  # kg·m²
VISCOUS: Range = (0.0, 2.0)  # N·m·s/rad
COULOMB: Range = (0.0, 5.0)  # N·m


class Chance(IntEnum):
    """What chance decides, each for itself: to change one leaves the others as they are."""

    ROBOT = 0
    TRAINING = 1
    VALIDATION = 2
    NOISE = 3
    FOLDS = 4


def chance(seed: int, joints: int, number: int, what: Chance) -> np.random.Generator:
    """Random numbers that depend on these and on nothing else."""
    return np.random.default_rng([seed, joints, number, int(what)])


def draw_robot(seed: int, joints: int, number: int) -> Robot:
    """The robot of a number, the same however many there are.

    Args:
        seed: of the study.  joints: N.  number: from 0 up.
    """
    random = chance(seed, joints, number, Chance.ROBOT)
    mass = random.uniform(*MASS, joints)
    return Robot(
        rotation=_twists(random.uniform(-np.pi, np.pi, joints)),
        offset=random.uniform(*OFFSET, (joints, 3)),
        mass=mass,
        centre=random.uniform(*CENTRE, (joints, 3)),
        inertia=mass[:, None, None] * np.array([_per_mass(random) for _ in range(joints)]),
        gear=random.uniform(*GEAR, joints),
        motor_inertia=random.uniform(*MOTOR_INERTIA, joints),
        viscous=random.uniform(*VISCOUS, joints),
        coulomb=random.uniform(*COULOMB, joints),
    )


def _twists(angle: Floats) -> Floats:
    """(N, 3, 3) rotations about x: how each axis leans against the one before."""
    out = np.zeros((len(angle), 3, 3))
    out[:, 0, 0] = 1.0
    out[:, 1, 1] = out[:, 2, 2] = np.cos(angle)
    out[:, 2, 1] = np.sin(angle)
    out[:, 1, 2] = -out[:, 2, 1]
    return out


def _per_mass(random: np.random.Generator) -> Floats:
    """(3, 3) m², inertia over mass about the centre of a body that leans in any direction."""
    axes, _ = np.linalg.qr(random.normal(size=(3, 3)))
    moments = random.uniform(*SPREAD, 3) ** 2
    return np.asarray(axes @ np.diag(moments.sum() - moments) @ axes.T)
