"""The closed loop without ROS: recorded in simulation, identified, and driven with the model."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrangian_ff.arm import Run, Trajectory, exciting_trajectory, simulate
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.recording import condition

Floats = NDArray[np.float64]

SPEED, TRAINING, UNSEEN = 4, 12.0, 6.0


@dataclass(frozen=True)
class Learned:
    """What was recorded, and what was learned from it."""

    training: Trajectory
    recorded: Run
    model: Model

    def without_friction(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """The torque less viscous and Coulomb friction and offset."""
        terms = self.model.terms(q, qd, qdd)
        return terms.total - terms.friction


@pytest.fixture(scope="module")
def learned() -> Learned:
    training = exciting_trajectory(SPEED, 0, TRAINING)
    recorded = simulate(training, seed=1)
    settings = Settings(model="vrbfs+fri", train=1.0, samples=300)
    return Learned(training, recorded, identify(condition(recorded.recording), settings).model)


@pytest.fixture(scope="module")
def unseen() -> Trajectory:
    return exciting_trajectory(SPEED, 1, UNSEEN)


def error(run: Run) -> float:
    """RMS over time and joints, rad."""
    return float(np.sqrt(np.mean(run.tracking_error**2)))


def test_on_the_motion_it_learned_from_a_third_of_the_error_is_left_at_most(
    learned: Learned,
) -> None:
    driven = simulate(learned.training, learned.model.predict, seed=2)
    assert error(driven) <= error(learned.recorded) / 3.0


def test_on_a_motion_it_never_saw_half_of_the_error_is_left_at_most_and_each_part_helps(
    learned: Learned, unseen: Trajectory
) -> None:
    none, without, full, bound = (
        error(simulate(unseen, feedforward, seed=3))
        for feedforward in (None, learned.without_friction, learned.model.predict, "true")
    )
    assert full <= none / 2.0
    assert none > without > full > bound


def test_the_torque_of_another_motion_makes_it_worse(learned: Learned, unseen: Trajectory) -> None:
    """What helps is the model's torque for this motion, not torque as such."""
    reverse = learned.model.predict(unseen.q[::-1], unseen.qd[::-1], unseen.qdd[::-1])
    assert error(simulate(unseen, reverse, seed=3)) > error(simulate(unseen, seed=3))
