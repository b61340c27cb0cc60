"""A learned chain as a polynomial is the sum over states that it was made of."""

import numpy as np
import pytest
from test_structured_kernels import random_kernel, random_states

from lagrangian_ff.kernels import KERNELS, Chain
from lagrangian_ff.kernels.structured.base import BlockSum
from lagrangian_ff.kernels.structured.polynomial import MOST_JOINTS, Polynomial


@pytest.mark.parametrize("joints", [1, 2, 3, 6])
def test_the_torques_are_those_of_the_sum(joints: int) -> None:
    kernel = random_kernel(Chain, joints, 3)
    u, x = random_states(150, joints, 1), random_states(9, joints, 2)
    a = np.random.default_rng(0).normal(size=(150, joints))
    learned = kernel.learned(u, a)
    assert isinstance(learned, Polynomial)
    expected = kernel.apply(x, u, a)
    np.testing.assert_allclose(learned.torque(x), expected, atol=1e-12 * abs(expected).max())


def test_a_joint_that_slides_has_no_polynomial() -> None:
    kernel = random_kernel(Chain, 3, 3, sliding=1)
    assert isinstance(kernel.learned(random_states(5, 3, 1), np.ones((5, 3))), BlockSum)


def test_too_many_joints_stay_a_sum() -> None:
    joints = MOST_JOINTS + 1
    kernel = random_kernel(Chain, joints, 3)
    assert isinstance(kernel.learned(random_states(5, joints, 1), np.ones((5, joints))), BlockSum)


@pytest.mark.parametrize("name", sorted(KERNELS))
def test_every_kernel_learns_what_it_applies(name: str) -> None:
    u, x = random_states(8, 3, 1), random_states(5, 3, 2)
    kernel, a = KERNELS[name].start(u), np.random.default_rng(0).normal(size=(8, 3))
    expected = kernel.apply(x, u, a)
    scale = max(1.0, float(abs(expected).max()))
    np.testing.assert_allclose(kernel.learned(u, a).torque(x), expected, atol=1e-12 * scale)
