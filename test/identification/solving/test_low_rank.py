"""Variance and response of a model on inducing points, against dense formulas."""

from dataclasses import replace

import numpy as np
import pendulum
import pytest
from numpy.typing import NDArray
from problems import problem_of

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.mechanics.positive import keep_positive
from lagrangian_ff.identification.problem import Scaling
from lagrangian_ff.identification.samples import evenly, groups
from lagrangian_ff.identification.solving.posterior import Posterior, exact, inducing_solver
from lagrangian_ff.kernels import KERNELS, LagrangianKernel, States

Floats = NDArray[np.float64]

EVERY = sorted(KERNELS)
LAGRANGIAN = [name for name, kernel in KERNELS.items() if issubclass(kernel, LagrangianKernel)]
FOLD = np.arange(60) // 6 % 5
AT = Inputs.of(pendulum.states(3.0, 1.0, seed=5)[1])


def pair(name: str, noise: float = 0.02, per_joint: bool = False) -> tuple[Posterior, Posterior]:
    """Return a fit with every sample as an inducing point, and the exact one."""
    motion = pendulum.motion(12.0, noise=noise)
    motion = motion.take(evenly(len(motion), len(FOLD)))
    problem = problem_of(motion, f"{name}+fri", Scaling.of(motion.tau, per_joint))
    raised = inducing_solver(problem, problem.samples.states, groups(FOLD))(None)
    systems = tuple((joints, b, replace(one, factor=1.0)) for joints, b, one in raised.systems)
    return replace(raised, problem=problem, systems=systems), exact(problem)


@pytest.mark.parametrize("name", EVERY)
def test_with_all_samples_as_inducing_points_it_has_the_variance_of_the_exact_fit(
    name: str,
) -> None:
    found, exact = pair(name, per_joint=True)
    ours, theirs = found.variance(AT), exact.variance(AT)
    for part in ("prior", "kernel", "basis", "noise"):
        one, other = getattr(ours, part), getattr(theirs, part)
        np.testing.assert_allclose(one, other, rtol=1e-5, atol=1e-8 * theirs.prior.max() + 1e-12)
    left_out, expected = (fit.left_out_deviation(groups(FOLD)) for fit in (found, exact))
    np.testing.assert_allclose(left_out, expected, rtol=1e-5)


@pytest.mark.parametrize("factor", [1.0, 10.0])
def test_inducing_points_keep_the_prior_of_what_they_cannot_express(factor: float) -> None:
    """It is the dense form of Bayes' rule on the features plus the rest of the prior."""
    found, exact = pair("vrbfs")
    ((joints, basis, system),) = found.systems
    few = States(*(column[::6] for column in (found.states.q, found.states.qd, found.states.qdd)))
    made = type(system.points).of(found.problem.kernel, few, joints)
    fewer = replace(type(system).of(made, system.rows, system.groups), factor=factor)
    ours = replace(found, states=few, systems=((joints, basis, fewer),)).variance(AT)
    at, rows = States(AT.q, AT.qd, AT.qdd), system.rows
    features, there = made.features(found.states), made.features(at)
    inverse = np.linalg.inv(features @ features.T + factor * np.diag(rows.noise))
    cross = features @ there.T
    left = basis.design(AT).reshape(len(AT) * 2, -1) / found.problem.unit[0]
    left = left - cross.T @ inverse @ rows.design()
    information = rows.design().T @ inverse @ rows.design()
    amplitude = factor * fewer.amplitude * found.problem.unit[0] ** 2
    prior = found.problem.kernel.variance(at).ravel()
    kernel = prior - np.einsum("ni,nm,mi->i", cross, inverse, cross)
    added = np.einsum("ib,bc,ic->i", left, np.linalg.inv(information), left)
    np.testing.assert_allclose(ours.kernel.ravel(), amplitude * kernel, rtol=1e-6)
    np.testing.assert_allclose(ours.basis.ravel(), amplitude * added, rtol=1e-6)
    assert (ours.kernel > exact.variance(AT).kernel * ours.prior / exact.variance(AT).prior).all()


@pytest.mark.parametrize("name", LAGRANGIAN)
def test_with_all_samples_as_inducing_points_it_is_kept_positive_as_the_exact_fit(
    name: str,
) -> None:
    """Both factors give the least change to the same fit."""
    found, exact = pair(name, noise=1.0)
    ours, theirs = (keep_positive(fit, exact.states) for fit in (found, exact))
    assert len(theirs.states) > len(exact.states)
    at = States(AT.q, AT.qd, AT.qdd)
    one, other = (exact.problem.kernel.apply(at, e.states, e.weights) for e in (ours, theirs))
    np.testing.assert_allclose(one, other, atol=1e-4 * np.abs(other).max())
    np.testing.assert_allclose(ours.coefficients, theirs.coefficients, atol=1e-3)
