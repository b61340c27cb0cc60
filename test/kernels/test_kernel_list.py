"""What every kernel of the shared list must be, whatever it models."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mechanism_examples import Crossed, robot
from numpy.typing import NDArray

from lagrangian_ff.errors import ModelError
from lagrangian_ff.kernels import (
    KERNELS,
    CoupledKernel,
    IndependentKernel,
    Kernel,
    LagrangianKernel,
    States,
)

Floats = NDArray[np.float64]

EVERY = sorted(KERNELS)
MECHANISMS = {
    f"{name} of {about}": mechanism.around(KERNELS[name])
    for about, mechanism in (("known bodies", robot()), ("a linkage", Crossed()))
    for name in ("none", "rbfs", "vrbfs", "chain", "energy_rbf")
}
FAMILIES = {**KERNELS, **MECHANISMS}
COUPLED = [name for name in EVERY if issubclass(KERNELS[name], CoupledKernel)]
LAGRANGIAN = [name for name in EVERY if issubclass(KERNELS[name], LagrangianKernel)]
INDEPENDENT = [name for name in EVERY if issubclass(KERNELS[name], IndependentKernel)]


def random_states(samples: int, joints: int, seed: int) -> States:
    """States of moderate motion."""
    rng = np.random.default_rng(seed)
    q, qd, qdd = (scale * rng.normal(size=(samples, joints)) for scale in (1.5, 1.0, 3.0))
    return States.of(q, qd, qdd)


def dense(kernel: Kernel, x: States, u: States) -> Floats:
    """(M_x, N, M_u, N) whatever shape the kernel is stored in."""
    joints = x.joints
    if isinstance(kernel, CoupledKernel):
        return kernel.cross(x, u).reshape(len(x), joints, len(u), joints)
    assert isinstance(kernel, IndependentKernel)
    out = np.zeros((len(x), joints, len(u), joints))
    for joint in range(joints):
        out[:, joint, :, joint] = kernel.cross(x, u, joint)
    return out


@dataclass(frozen=True)
class Case:
    """A kernel and states to try it on."""

    kernel: Kernel
    x: States
    u: States


@pytest.fixture(params=sorted(FAMILIES))
def case(request: pytest.FixtureRequest) -> Case:
    """Return each kernel with its starting values on three joints."""
    x, u = random_states(7, 3, 1), random_states(5, 3, 2)
    return Case(FAMILIES[request.param].start(x), x, u)


def test_gram_matrix_is_symmetric_and_positive_semidefinite(case: Case) -> None:
    size = len(case.x) * 3
    gram = dense(case.kernel, case.x, case.x).reshape(size, size)
    np.testing.assert_allclose(gram, gram.T, atol=1e-13 * max(1.0, abs(gram).max()))
    assert np.linalg.eigvalsh(gram).min() > -1e-10 * max(1.0, abs(gram).max())


def test_swapping_the_states_transposes_the_block(case: Case) -> None:
    there, back = dense(case.kernel, case.x, case.u), dense(case.kernel, case.u, case.x)
    np.testing.assert_allclose(there, back.transpose(2, 3, 0, 1), atol=1e-13)


def test_gram_is_what_cross_gives(case: Case) -> None:
    expected = dense(case.kernel, case.x, case.x)
    if isinstance(case.kernel, CoupledKernel):
        lower = np.tril(np.ones((len(case.x), len(case.x)), dtype=bool))
        blocks = case.kernel.gram(case.x).reshape(expected.shape)
        for i, j in zip(*np.nonzero(lower), strict=True):
            np.testing.assert_allclose(blocks[i, :, j, :], expected[i, :, j, :], atol=1e-14)
    else:
        assert isinstance(case.kernel, IndependentKernel)
        for joint in range(3):
            gram = case.kernel.gram(case.x, joint)
            np.testing.assert_allclose(gram, expected[:, joint, :, joint], atol=1e-14)


def test_applying_equals_forming_and_multiplying(case: Case) -> None:
    a = np.random.default_rng(3).normal(size=(len(case.u), 3))
    expected = np.einsum("injm,jm->in", dense(case.kernel, case.x, case.u), a)
    np.testing.assert_allclose(case.kernel.apply(case.x, case.u, a), expected, atol=1e-12)


def test_variance_is_the_diagonal(case: Case) -> None:
    expected = np.einsum("inin->in", dense(case.kernel, case.x, case.x))
    np.testing.assert_allclose(case.kernel.variance(case.x), expected, atol=1e-12)


def test_hyperparameters_can_be_replaced_and_read_back(case: Case) -> None:
    for name, value in case.kernel.hyperparameters.items():
        changed = case.kernel.replace(**{name: value * 2.0})
        np.testing.assert_array_equal(changed.hyperparameters[name], value * 2.0)


def test_says_what_it_is(case: Case) -> None:
    assert case.kernel.meaning
    named = {h.name for h in case.kernel.searched}
    assert named <= set(case.kernel.hyperparameters)
    assert all(h.low < 1.0 < h.high for h in case.kernel.searched)


@pytest.mark.parametrize("name", LAGRANGIAN)
def test_torques_are_those_of_the_lagrangian_it_tells(name: str) -> None:
    """Eq. (31) under the Euler-Lagrange operator, derivatives taken by differences."""
    x, u = random_states(4, 3, 6), random_states(40, 3, 7)
    a = np.random.default_rng(8).normal(size=(40, 3))
    kernel = KERNELS[name].start(u)
    rng = np.random.default_rng(9)
    for wave in {"wave", "swing"} & set(kernel.hyperparameters):
        kernel = kernel.replace(**{wave: rng.uniform(0.3, 2.0, 3)})
    assert isinstance(kernel, LagrangianKernel)

    def moved(step: float, q: Floats, qd: Floats) -> States:
        return States.of(x.q + step * q, x.qd + step * qd, 0.0 * x.q)

    def slope(told: Callable[[States, States, Floats], Floats], q: Floats, qd: Floats) -> Floats:
        h = 1e-3
        one, two = (
            told(moved(k * h, q, qd), u, a) - told(moved(-k * h, q, qd), u, a) for k in (1, 2)
        )
        return np.asarray((8.0 * one - two) / (12.0 * h))

    still = np.zeros((4, 3))
    each = [still + along for along in np.eye(3)]
    momentum = np.stack([slope(kernel.lagrangian, still, along) for along in each], axis=1)
    scale = np.abs(momentum).max()
    np.testing.assert_allclose(kernel.momentum(x, u, a), momentum, atol=1e-8 * scale)
    force = np.stack([slope(kernel.lagrangian, along, still) for along in each], axis=1)
    torque = slope(kernel.momentum, x.qd, x.qdd) - force
    np.testing.assert_allclose(kernel.apply(x, u, a), torque, atol=1e-8 * np.abs(torque).max())
    assert kernel.quadratic == np.allclose(
        kernel.momentum(moved(1.0, still, x.qd), u, a), 2.0 * kernel.momentum(x, u, a)
    )


@pytest.mark.parametrize("name", INDEPENDENT)
def test_joints_may_have_hyperparameters_of_their_own(name: str) -> None:
    x, u = random_states(6, 2, 4), random_states(5, 2, 5)
    common = KERNELS[name].start(x)
    for hyperparameter, value in common.hyperparameters.items():
        own = common.replace(**{hyperparameter: np.array([value[0], 3.0 * value[0]])})
        second = common.replace(**{hyperparameter: np.array([3.0 * value[0]])})
        assert isinstance(own, IndependentKernel)
        assert isinstance(common, IndependentKernel)
        assert isinstance(second, IndependentKernel)
        np.testing.assert_allclose(own.cross(x, u, 0), common.cross(x, u, 0))
        np.testing.assert_allclose(own.cross(x, u, 1), second.cross(x, u, 1))
        a = np.ones((5, 2))
        np.testing.assert_allclose(own.apply(x, u, a)[:, 1], second.apply(x, u, a)[:, 1])
        np.testing.assert_allclose(own.variance(x)[:, 1], second.variance(x)[:, 1])


@pytest.mark.parametrize("name", ["rbfs", "srbfs", "svrbfs", "vrbfs", "pol"])
@given(turns=st.integers(-3, 3), seed=st.integers(0, 100))
def test_a_full_turn_of_a_revolute_joint_changes_nothing(name: str, turns: int, seed: int) -> None:
    x, u = random_states(3, 2, seed), random_states(3, 2, seed + 1)
    turned = States.of(x.q + 2.0 * np.pi * turns, x.qd, x.qdd)
    kernel = KERNELS[name].start(x)
    np.testing.assert_allclose(dense(kernel, turned, u), dense(kernel, x, u), atol=1e-11)


@pytest.mark.parametrize("shape", [(3, 2), (2, 3), (4,)])
def test_states_of_different_shapes_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ModelError, match="one shape"):
        States.of(np.zeros((3, 3)), np.zeros(shape), np.zeros((3, 3)))
