"""The relaxed problem (42), (43) against its own formulas, written out."""

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.problem import Prior, Problem, Scaling
from lagrangian_ff.identification.samples import Samples, groups
from lagrangian_ff.identification.solving.posterior import exact
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.kernels import KERNELS, States
from lagrangian_ff.kernels.dense import dense_cross, together
from lagrangian_ff.studies.paper import RHO, Relaxed, Setting, solve

JOINTS = 2
NAMES = ("rbfs", "srbf", "vrbfs", "motor")


def states(count: int, seed: int) -> States:
    random = np.random.default_rng(seed)
    return States.of(*(random.uniform(-2.0, 2.0, (count, JOINTS)) for _ in range(3)))


X, ASKED = states(15, 0), states(7, 1)
TAU = np.random.default_rng(2).normal(size=(15, JOINTS))
GAMMA, SIGMA_F = np.array([1e-3, 1e-3]), np.array([0.1, 0.1])


def setting(name: str, *, friction: bool = True) -> Setting:
    return Setting(KERNELS[name].start(X), GAMMA, SIGMA_F if friction else None)


def friction_kernel(x: States, u: States) -> NDArray[np.float64]:
    """Return (51) with the velocities brought to 1, entry by entry."""
    most = np.abs(X.qd).max()
    out = np.zeros((len(x), JOINTS, len(u), JOINTS))
    for n in range(JOINTS):
        v, w = x.qd[:, n, None], u.qd[None, :, n]
        out[:, n, :, n] = v * w / most**2 + np.tanh(v / 0.1) * np.tanh(w / 0.1) + 1.0
    return out.reshape(len(x) * JOINTS, -1)


@pytest.mark.parametrize("name", NAMES)
def test_it_solves_the_sum_of_the_two_kernels(name: str) -> None:
    found = Relaxed.learned(setting(name), X, TAU).torque(ASKED)
    kernel = KERNELS[name].start(X)
    dynamic = dense_cross(kernel, X, X), dense_cross(kernel, ASKED, X)
    friction = friction_kernel(X, X), friction_kernel(ASKED, X)
    expected = np.empty_like(found)
    for joints in together(kernel, JOINTS):
        rows = np.isin(np.arange(len(X) * JOINTS) % JOINTS, joints)
        own = np.ix_(rows, rows)
        rho = RHO * np.trace(dynamic[0][own]) / np.trace(friction[0][own])
        gram, cross = ((d / (1 - rho) + f / rho) for d, f in zip(dynamic, friction, strict=True))
        regularised = gram[own] + 1e-3 * len(X) * np.eye(rows.sum())
        a = np.linalg.solve(regularised, TAU.ravel()[rows])
        torque = (cross[:, rows] @ a).reshape(-1, JOINTS)
        expected[:, list(joints)] = torque[:, list(joints)]
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_without_friction_it_is_what_identification_solves(name: str) -> None:
    ones = np.ones(JOINTS)
    kernel, samples = KERNELS[name].start(X), Samples(Inputs.of(X), TAU)
    problem = Problem(samples, Prior(kernel, GAMMA * len(X), Scaling(ones, ones), Basis(())))
    known = exact(problem).weights
    found = Relaxed.learned(setting(name, friction=False), X, TAU)
    expected = kernel.apply(ASKED, X, known)
    np.testing.assert_allclose(found.torque(ASKED), expected, rtol=1e-9, atol=1e-12)
    again = Relaxed.learned(setting(name), X, TAU + 1.0).without_friction(TAU)
    np.testing.assert_allclose(again.torque(ASKED), expected, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("name", ["vrbfs", "rbf"])
def test_samples_left_out_are_met_as_by_a_fit_without_them(name: str) -> None:
    folds = groups(np.arange(15) % 3)
    joints = together(KERNELS[name].start(X), JOINTS)[0]
    found = solve(setting(name, friction=False), X, TAU, joints).left_out(folds)
    expected = []
    for fold in folds:
        kept = np.setdiff1d(np.arange(15), fold)
        # γ M is that of all samples in the one factor, and of those kept in a fit of their own.
        own = Setting(KERNELS[name].start(X), GAMMA * 15 / len(kept), None)
        refit = Relaxed.learned(own, X.take(kept), TAU[kept])
        error = TAU[fold] - refit.torque(X.take(fold))
        expected.append(error[:, list(joints)].ravel())
    np.testing.assert_allclose(found, np.concatenate(expected), rtol=1e-7, atol=1e-9)


def test_too_little_regularisation_is_raised_and_recorded() -> None:
    twice = States.of(*(np.vstack([part, part]) for part in (X.q, X.qd, X.qdd)))
    little = Setting(KERNELS["rbf"].start(X), np.full(JOINTS, 1e-20), None)
    learned = Relaxed.learned(little, twice, np.vstack([TAU, TAU]))
    assert learned.record()["gamma"] == 1e-20
    raised = learned.record()["gamma_raised"]
    assert isinstance(raised, float)
    assert raised > 1.0
    np.testing.assert_allclose(learned.torque(X), TAU, atol=1e-6)


def test_a_kernel_as_large_as_to_leave_no_rho_is_refused() -> None:
    small = KERNELS["srbf"].start(X).replace(sigma=np.array([1e-8]))
    with pytest.raises(NotPositiveDefiniteError, match="rho is"):
        Relaxed.learned(Setting(small, GAMMA, SIGMA_F), X, TAU)
