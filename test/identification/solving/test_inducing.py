"""The fit on landmarks, against the exact fit that it stands for."""

from dataclasses import replace

import numpy as np
import pendulum
import pytest
from problems import problem_of

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.problem import Scaling, rows_of
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.solving.low_rank import LowRank
from lagrangian_ff.identification.solving.posterior import Posterior, exact, inducing_solver
from lagrangian_ff.kernels import KERNELS, States
from lagrangian_ff.recording.motion import Motion

EVERY = sorted(KERNELS)
FRESH = pendulum.motion(10.0, 20.0, seed=0)


def inputs(motion: Motion) -> Inputs:
    return Inputs.of(States.of(motion.q, motion.qd, motion.qdd))


def predict(model: Posterior, motion: Motion) -> np.ndarray:
    x = inputs(motion)
    states = States(x.q, x.qd, x.qdd)
    problem = model.problem
    kernel = problem.kernel.apply(states, model.states, model.weights) * problem.unit
    return kernel + sum(problem.basis.torque(x, model.coefficients).values())


def folds(samples: int, count: int = 5) -> list[np.ndarray]:
    block = np.arange(samples) * 30 // samples % count
    return [np.flatnonzero(block == number) for number in range(count)]


def on_points(motion: Motion, name: str, count: int, per_joint: bool = True) -> Posterior:
    problem = problem_of(motion, name, Scaling.of(motion.tau, per_joint))
    at = problem.samples.states.take(evenly(len(motion), count))
    return inducing_solver(problem, at, folds(len(motion)))(None)


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("per_joint", [True, False])
def test_with_all_samples_as_inducing_points_it_is_the_exact_fit(
    name: str, per_joint: bool
) -> None:
    motion = pendulum.motion(12.0, noise=0.02)
    motion = motion.take(evenly(len(motion), 60))
    groups = folds(60)
    found = on_points(motion, f"{name}+fri", 60, per_joint)
    every = exact(found.problem)
    size = motion.tau.std()
    np.testing.assert_allclose(predict(found, FRESH), predict(every, FRESH), atol=1e-6 * size)
    np.testing.assert_allclose(found.coefficients, every.coefficients, atol=1e-6)
    np.testing.assert_allclose(found.deviations, every.deviations, rtol=1e-5, atol=1e-9)
    assert found.log_evidence == pytest.approx(every.log_evidence, abs=1e-4)
    residual, expected = found.left_out(groups), every.left_out(groups)
    np.testing.assert_allclose(residual, expected, atol=1e-6 * size)
    for (joints, _, one), (_, _, other) in zip(found.systems, every.systems, strict=True):
        rows = [rows_of(group, len(joints)) for group in groups]
        for left, same in zip(one.left_out(rows), other.left_out(rows), strict=True):
            np.testing.assert_allclose(left.change, same.change, atol=1e-6)


def test_the_chunks_do_not_matter() -> None:
    """In another order of the samples, every chunk holds others."""
    motion = pendulum.motion(50.0, noise=0.02)
    problem = problem_of(motion, "vrbfs+fri", Scaling.of(motion.tau, True))
    points = problem.samples.states.take(evenly(len(motion), 300))
    order = np.random.default_rng(0).permutation(len(motion))
    groups, place = folds(len(motion)), np.argsort(order)
    among = [np.sort(place[group]) for group in groups]
    whole = inducing_solver(problem, points, groups)(None)
    assert len(list(whole.systems[0][2].points.chunks(order))) > 1
    mixed = replace(problem, samples=problem.samples.take(order))
    parts = inducing_solver(mixed, points, among)(None)
    np.testing.assert_allclose(predict(parts, FRESH), predict(whole, FRESH), atol=1e-6)
    np.testing.assert_allclose(parts.coefficients, whole.coefficients, atol=1e-6)
    left = parts.left_out(among)[place]
    np.testing.assert_allclose(left, whole.left_out(groups), atol=1e-6)


def test_every_torque_has_its_own_noise() -> None:
    """A torque with much noise does not count."""
    rng = np.random.default_rng(1)
    motion = pendulum.motion(12.0, 20.0, noise=0.01)
    rows = on_points(motion, "vrbfs+fri", 30).systems[0][2].rows
    system = on_points(motion, "vrbfs+fri", 30).systems[0][2]
    wrong = rng.permutation(system.count)[:40]
    target, noise = rows.target.copy(), rows.noise.copy()
    target[wrong] += 100.0
    noise[wrong] *= 1e9
    noisy = LowRank.of(system.points, replace(rows, target=target, noise=noise), system.groups)
    plain = LowRank.of(system.points, rows, system.groups)
    moved = np.abs(noisy.coefficients - plain.coefficients)
    assert moved.max() < 0.1 * np.abs(plain.coefficients).max()


@pytest.mark.parametrize("name", ["vrbfs+fri", "chain+fri"])
def test_intervals_of_the_effects_are_nearly_those_of_the_exact_fit(name: str) -> None:
    motion = pendulum.motion(90.0, 10.0, noise=0.05)
    found = on_points(motion, name, 300)
    every = exact(found.problem)
    blocks = [np.arange(first, first + 10) for first in range(0, len(motion), 10)]
    ours, theirs = (np.std(one.changed(blocks), axis=0) for one in (found, every))
    np.testing.assert_allclose(ours, theirs, rtol=0.25)


def test_what_is_left_is_the_torque_less_the_prediction() -> None:
    motion = pendulum.motion(12.0, 20.0, noise=0.02)
    found = on_points(motion, "vrbfs+fri", 30)
    np.testing.assert_allclose(found.residual, motion.tau - predict(found, motion), atol=1e-9)
    np.testing.assert_allclose(found.torque(inputs(FRESH)), predict(found, FRESH), atol=1e-9)
