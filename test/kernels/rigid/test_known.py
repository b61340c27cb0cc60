"""The kernel of known bodies; what every kernel must be is asked of it by the shared list."""

import numpy as np
import pytest
from mechanism_examples import Crossed, robot
from numpy.typing import NDArray

from lagrangian_ff.kernels import KERNELS, DifferentiableKernel, LagrangianKernel, Mechanism, States
from lagrangian_ff.kernels.rigid.known import Known

Floats = NDArray[np.float64]


def random_states(samples: int, seed: int) -> States:
    rng = np.random.default_rng(seed)
    return States.of(*(scale * rng.normal(size=(samples, 3)) for scale in (1.0, 1.0, 3.0)))


def learned(kernel: Known, x: States, torque: Floats) -> Floats:
    """(M, 3) coefficients of an almost exact fit."""
    gram = kernel.cross(x, x)
    gram += 1e-12 * np.trace(gram) / len(gram) * np.eye(len(gram))
    return np.asarray(np.linalg.solve(gram, torque.ravel()).reshape(torque.shape), np.float64)


def start(name: str, x: States) -> Known:
    kernel = robot().around(KERNELS[name]).start(x)
    assert isinstance(kernel, Known)
    return kernel


def test_torques_of_any_masses_are_learned_exactly() -> None:
    x, u = random_states(40, 1), random_states(40, 2)
    kernel, tree = start("none", u), robot().tree
    others = tree.inertial * np.random.default_rng(3).uniform(0.5, 1.5, tree.inertial.shape)
    rotors = np.array([0.3, 0.1, 0.02])

    def torque(at: States) -> Floats:
        return np.asarray(tree.regressor(at) @ others.ravel() + rotors * at.qdd)

    found = kernel.apply(x, u, learned(kernel, u, torque(u)))
    assert np.abs(found - torque(x)).max() < 1e-6 * np.abs(torque(x)).max()


def test_inertial_parameters_found_give_the_torque_of_the_bodies() -> None:
    x, u = random_states(10, 1), random_states(40, 2)
    kernel, tree = start("none", u).replace(armature=np.full(3, 1e-6)), robot().tree
    a = learned(kernel, u, 1.3 * tree.torque(u))
    found = tree.regressor(x) @ kernel.inertial(u, a).ravel()
    np.testing.assert_allclose(found, 1.3 * tree.torque(x), rtol=1e-5, atol=1e-5)


def test_with_little_data_the_description_is_believed() -> None:
    x, u = random_states(100, 1), random_states(2, 2)
    tree = robot().tree
    truth = tree.torque(x)
    known, blind = start("vrbfs", random_states(100, 4)), KERNELS["vrbfs"].start(u)
    error = known.apply(x, u, learned(known, u, tree.torque(u))) - truth
    gram = np.asarray(blind.cross(u, u)) + 1e-9 * np.eye(6)  # type: ignore[attr-defined]
    weights = np.linalg.solve(gram, tree.torque(u).ravel()).reshape(2, 3)
    assert np.std(error) < 0.3 * np.std(blind.apply(x, u, np.asarray(weights)) - truth)


def test_the_correcting_kernel_is_told_which_joints_slide() -> None:
    kernel = start("chain", random_states(10, 1))
    np.testing.assert_array_equal(kernel.hyperparameters["prismatic"], [0.0, 0.0, 1.0])


def test_applying_again_to_other_states_or_coefficients_is_not_mixed_up() -> None:
    x, u, v = random_states(4, 1), random_states(6, 2), random_states(6, 3)
    kernel, a, b = start("none", u), *np.random.default_rng(4).normal(size=(2, 6, 3))
    for at, weights in ((u, a), (v, a), (u, b), (u, a)):
        expected = kernel.cross(x, at) @ weights.ravel()
        np.testing.assert_allclose(kernel.apply(x, at, weights).ravel(), expected, rtol=1e-9)


@pytest.mark.parametrize("mechanism", [robot(), Crossed()], ids=["known", "closed"])
@pytest.mark.parametrize("name", ["chain", "energy_rbf"])
def test_derivatives_are_those_of_differences(mechanism: Mechanism, name: str) -> None:
    x = random_states(20, 5)
    kernel = mechanism.around(KERNELS[name]).start(x)
    assert isinstance(kernel, DifferentiableKernel)
    rng = np.random.default_rng(0)
    weights, vector = rng.normal(size=(60, 60)), rng.normal(size=60)
    weights += weights.T
    found = kernel.contract(x, np.tril(weights), vector)
    assert set(found) == set(kernel.differentiable)
    for number, derivative in found.items():
        value = kernel.hyperparameters[number]
        for place, step in enumerate(1e-4 * np.eye(len(value)) * value):
            up, down = (kernel.replace(**{number: value + sign * step}) for sign in (1.0, -1.0))
            assert isinstance(up, DifferentiableKernel)
            assert isinstance(down, DifferentiableKernel)
            slope = (up.cross(x, x) - down.cross(x, x)) / (2.0 * step.sum())
            scale = float(np.abs(slope).max())
            np.testing.assert_allclose(derivative.product[place], slope @ vector, atol=1e-4 * scale)
            total = float(np.sum(weights * slope))
            np.testing.assert_allclose(derivative.total[place], total, atol=1e-3 * scale)


@pytest.mark.parametrize("name", ["chain", "vrbfs"])
def test_the_torque_is_that_of_the_lagrangian_it_tells(name: str) -> None:
    x, u = random_states(6, 1), random_states(20, 2)
    kernel, a = start(name, u), np.random.default_rng(3).normal(size=(20, 3))
    assert isinstance(kernel, LagrangianKernel)
    step = 1e-5
    change, force = np.zeros((2, 6, 3))
    for sign in (1.0, -1.0):
        later = States.of(x.q + sign * step * x.qd, x.qd + sign * step * x.qdd, x.qdd)
        change += sign * kernel.momentum(later, u, a) / (2.0 * step)
        for n, one in enumerate(np.eye(3)):
            moved = States.of(x.q + sign * step * one, x.qd, x.qdd)
            force[:, n] += sign * kernel.lagrangian(moved, u, a) / (2.0 * step)
    expected = kernel.apply(x, u, a)
    np.testing.assert_allclose(change - force, expected, atol=1e-6 * np.abs(expected).max())
