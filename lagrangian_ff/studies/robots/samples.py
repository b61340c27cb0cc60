"""What is learned from a robot, and what is asked of who has learned it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels import States
from lagrangian_ff.studies.robots.draw import Chance, chance, draw_robot

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# q in rad, qd in rad/s and qdd in rad/s² reach from minus to plus these. With half a second for the
# unit of time both rates reach 1, as in section IV.
REACH = (np.pi, 2.0, 4.0)


@dataclass(frozen=True)
class Scene:
    """What a study asks of its robots.

    Attributes:
        training, validation: how many samples.
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
        ideal: (M, N) torques there without friction.
        friction: (M, N) friction there, zero where the scene has none.
        noise: (M, N) of their measurement.
        fold: (M,) the fold of each training sample.
        asked: (V, N) validation states.
        truth: (V, N) torques there without noise, with friction where the scene has it.
        asked_friction: (V, N) friction there.
    """

    unit: float
    x: States
    ideal: Floats
    friction: Floats
    noise: Floats
    fold: Ints
    asked: States
    truth: Floats
    asked_friction: Floats

    @property
    def tau(self) -> Floats:
        """(M, N) what is measured in training."""
        return self.ideal + self.friction + self.noise


def draw_samples(scene: Scene, seed: int, joints: int, number: int) -> Samples:
    """Samples of the robot of a number; see `draw_robot`."""
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
    return Samples(
        unit=unit,
        x=x,
        ideal=ideal / unit,
        friction=friction,
        noise=scene.noise * chance(seed, joints, number, Chance.NOISE).normal(size=ideal.shape),
        fold=order % scene.folds,
        asked=asked,
        truth=robot.torque(asked) / unit + asked_friction,
        asked_friction=asked_friction,
    )
