"""The fit on landmarks, against the exact fit that it stands for."""

from dataclasses import replace

import numpy as np
import pendulum
import pytest

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.choice import Scaling
from lagrangian_ff.identification.choosing.search import starting_choice
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.solving import landmarks
from lagrangian_ff.identification.solving.equations import fit_basis
from lagrangian_ff.identification.solving.fit import Fit
from lagrangian_ff.identification.solving.landmark_equations import LandmarkEquations
from lagrangian_ff.identification.solving.low_rank import LowRank
from lagrangian_ff.identification.spec import parse
from lagrangian_ff.kernels import KERNELS, States
from lagrangian_ff.recording.motion import Motion

EVERY = sorted(KERNELS)
FRESH = pendulum.motion(10.0, 20.0, seed=0)


def inputs(motion: Motion) -> Inputs:
    return Inputs.of(States.of(motion.q, motion.qd, motion.qdd))


def predict(model: Fit, motion: Motion) -> np.ndarray:
    x = inputs(motion)
    states = States(x.q, x.qd, x.qdd)
    kernel = model.choice.kernel.apply(states, model.states, model.weights) * model.scaling.unit
    return kernel + sum(model.basis.torque(x, model.coefficients).values())


def folds(samples: int, count: int = 5) -> list[np.ndarray]:
    block = np.arange(samples) * 30 // samples % count
    return [np.flatnonzero(block == number) for number in range(count)]


def on_landmarks(motion: Motion, name: str, count: int, per_joint: bool = True) -> Fit:
    x, spec = inputs(motion), parse(name)
    states = States(x.q, x.qd, x.qdd)
    choice = starting_choice(spec, states)
    at = states.take(evenly(len(states), count))
    scaling = Scaling.of(motion.tau, per_joint)
    basis = choice.basis(spec, x.joints)
    parts = basis, choice, x, motion.tau, scaling, at, folds(len(x))
    return LandmarkEquations.of(*parts).solve()


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("per_joint", [True, False])
def test_with_all_samples_as_landmarks_it_is_the_exact_fit(name: str, per_joint: bool) -> None:
    motion = pendulum.motion(12.0, noise=0.02)
    motion = motion.take(evenly(len(motion), 60))
    x, groups = inputs(motion), folds(60)
    found = on_landmarks(motion, f"{name}+fri", 60, per_joint)
    exact = fit_basis(found.basis, found.choice, x, motion.tau, found.scaling)
    size = motion.tau.std()
    np.testing.assert_allclose(predict(found, FRESH), predict(exact, FRESH), atol=1e-6 * size)
    np.testing.assert_allclose(found.coefficients, exact.coefficients, atol=1e-6)
    np.testing.assert_allclose(found.deviations, exact.deviations, rtol=1e-5, atol=1e-9)
    assert found.log_evidence == pytest.approx(exact.log_evidence, abs=1e-4)
    residual, changed = found.left_out(groups)
    expected, moved = exact.left_out(groups)
    np.testing.assert_allclose(residual, expected, atol=1e-6 * size)
    np.testing.assert_allclose(changed, moved, atol=1e-6)


def test_the_chunks_do_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    motion = pendulum.motion(12.0, 20.0, noise=0.02)
    whole = on_landmarks(motion, "vrbfs+fri", 30)
    monkeypatch.setattr(landmarks, "CHUNK_ENTRIES", 30 * 2 * 2 * 7)
    assert [len(c) for c in whole.systems[0][2].landmarks.chunks(np.arange(17))] == [7, 7, 3]
    parts = on_landmarks(motion, "vrbfs+fri", 30)
    np.testing.assert_allclose(predict(parts, FRESH), predict(whole, FRESH), atol=1e-6)
    np.testing.assert_allclose(parts.coefficients, whole.coefficients, atol=1e-7)
    groups = folds(len(motion))
    np.testing.assert_allclose(parts.left_out(groups)[0], whole.left_out(groups)[0], atol=1e-6)


def test_no_torque_of_another_noise_is_taken_for_its_neighbour() -> None:
    """The noise is that of every torque: what is not believed does not count."""
    rng = np.random.default_rng(1)
    motion = pendulum.motion(12.0, 20.0, noise=0.01)
    rows = on_landmarks(motion, "vrbfs+fri", 30).systems[0][2].rows
    system = on_landmarks(motion, "vrbfs+fri", 30).systems[0][2]
    wrong = rng.permutation(system.count)[:40]
    target, noise = rows.target.copy(), rows.noise.copy()
    target[wrong] += 100.0
    noise[wrong] *= 1e9
    doubted = LowRank.of(system.landmarks, replace(rows, target=target, noise=noise), system.groups)
    believed = LowRank.of(system.landmarks, rows, system.groups)
    moved = np.abs(doubted.coefficients - believed.coefficients)
    assert moved.max() < 0.1 * np.abs(believed.coefficients).max()


@pytest.mark.parametrize("name", ["vrbfs+fri", "chain+fri"])
def test_intervals_of_the_effects_are_nearly_those_of_the_exact_fit(name: str) -> None:
    motion = pendulum.motion(90.0, 10.0, noise=0.05)
    found = on_landmarks(motion, name, 300)
    exact = fit_basis(found.basis, found.choice, inputs(motion), motion.tau, found.scaling)
    blocks = [np.arange(first, first + 10) for first in range(0, len(motion), 10)]
    ours, theirs = (np.std(one.changed(blocks), axis=0) for one in (found, exact))
    np.testing.assert_allclose(ours, theirs, rtol=0.25)


def test_what_is_left_is_the_torque_less_the_prediction() -> None:
    motion = pendulum.motion(12.0, 20.0, noise=0.02)
    found = on_landmarks(motion, "vrbfs+fri", 30)
    np.testing.assert_allclose(found.residual, motion.tau - predict(found, motion), atol=1e-9)
    np.testing.assert_allclose(found.torque(inputs(FRESH)), predict(found, FRESH), atol=1e-9)
