"""The kernels that the paper compares with, against their formulas written out pair by pair."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from test_kernel_list import random_states

from lagrangian_ff.kernels import KERNELS, States
from lagrangian_ff.kernels.baselines import Motor, Rbf, Rbfs

Floats = NDArray[np.float64]

SIGMA, RATE, ACCELERATION = 2.3, 0.7, 0.2


def on_a_circle(q: Floats) -> Floats:
    """ψ(q) = (cos q, sin q), as below eq. (53)."""
    return np.concatenate([np.cos(q), np.sin(q)])


def as_it_is(q: Floats) -> Floats:
    return q


@pytest.mark.parametrize(("family", "psi"), [(Rbf, as_it_is), (Rbfs, on_a_circle)])
def test_rbf_is_of_squared_distances(family: type[Rbf], psi: Callable[[Floats], Floats]) -> None:
    """Eqs. (52) and (53), every norm squared, on rates brought to the scale of section IV."""
    x, u = random_states(4, 3, 1), random_states(5, 3, 2)
    kernel = family(np.array([SIGMA]), np.array([RATE]), np.array([ACCELERATION]))
    found = kernel.cross(x, u, 1)
    for i in range(4):
        for j in range(5):
            squared = (
                np.sum((psi(x.q[i]) - psi(u.q[j])) ** 2)
                + np.sum((RATE * (x.qd[i] - u.qd[j])) ** 2)
                + np.sum((ACCELERATION * (x.qdd[i] - u.qdd[j])) ** 2)
            )
            assert found[i, j] == pytest.approx(np.exp(-squared / (2.0 * SIGMA)), rel=1e-12)


@pytest.mark.parametrize("name", ["rbf", "rbfs", "pol", "motor"])
def test_rates_are_brought_to_one(name: str) -> None:
    """Section IV: |qd| and |qdd| are at most 1 on the training motion, each for itself."""
    x = random_states(20, 3, 3)
    scales = KERNELS[name].start(x).hyperparameters
    assert np.abs(scales["velocity_scale"] * x.qd).max() == pytest.approx(1.0)
    assert np.abs(scales["acceleration_scale"] * x.qdd).max() == pytest.approx(1.0)


def test_motor_is_an_inertia_and_a_loss_of_the_joint_alone() -> None:
    """Eq. (54): two numbers a joint, learned exactly from two samples."""
    u, x = random_states(2, 3, 4), random_states(6, 3, 5)
    kernel, c1, c2 = Motor.start(u), 0.8, -2.5

    def torque(at: States) -> Floats:
        return np.asarray(c1 * at.qdd[:, 1] + c2 * at.qd[:, 1])

    a = np.linalg.solve(kernel.cross(u, u, 1), torque(u))
    np.testing.assert_allclose(kernel.cross(x, u, 1) @ a, torque(x), rtol=1e-9)
