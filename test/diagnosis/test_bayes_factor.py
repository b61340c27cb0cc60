"""A refitted log Bayes factor compares a candidate with the best model without it."""

from dataclasses import replace

import numpy as np
import pytest
import two_rods
from scipy.stats import multivariate_normal
from whitened_examples import begun, clean_rods, dense, few_torques, whitened_of

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.search.bayes_factor import (
    PRIOR_SHARE,
    bayes_factors,
    best_shape,
    log_bayes_factor_of,
    refined,
)
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.diagnosis.search.judging import evidence_without
from lagrangian_ff.diagnosis.whitening import Whitened
from lagrangian_ff.diagnosis.whitening.whitened import chain_of
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.effects.formula import Range, formula_effect
from lagrangian_ff.identification.problem import Nuisance

_small = few_torques(1000)


clean = pytest.fixture(scope="module")(clean_rods)


def with_prior(whitened: Whitened, **changed: np.ndarray) -> Whitened:
    """Return the motion whitened with another kernel or other noise."""
    problem = whitened.problem
    noise = changed.pop("noise", problem.noise)
    kernel = problem.kernel.replace(**changed) if changed else problem.kernel
    return whitened.assuming(problem.having(kernel=kernel, noise=noise))


def without(whitened: Whitened) -> float:
    """Return the best log evidence that is reached without a candidate."""
    return max(whitened.system.log_evidence, evidence_without(whitened))


def test_it_is_a_difference_of_log_evidence(clean: Whitened) -> None:
    """Against the definition, with dense matrices, on a few samples and without a basis."""
    small = begun(clean, 40)
    candidate = Candidate(EFFECTS["asymmetric_viscous"], 1)
    (score,) = bayes_factors(small, [candidate])
    columns = candidate.columns(small.x)
    amplitude = small.explaining(small.basis, (Nuisance(1, columns),)).system.amplitude
    scale = PRIOR_SHARE * small.spread[1] / np.sqrt(np.mean(columns**2, axis=0))
    full = np.zeros((40, 2, columns.shape[1]))
    full[:, 1] = columns * scale / small.problem.unit[1]
    flat = full.reshape(80, -1)
    gram, y = dense(small)
    expected = multivariate_normal.logpdf(y, cov=amplitude * gram + flat @ flat.T)
    untempered = log_bayes_factor_of(score, small, 0.0) * score.variance_inflation
    assert untempered == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("centre", [0.2, 0.25])
def test_a_narrow_place_is_found_where_a_wide_grid_stands_beside_it(
    clean: Whitened, centre: float
) -> None:
    def sore(t: np.ndarray, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        near = np.exp(-(((q[:, 0] - centre) / 0.1) ** 2))
        return np.outer(3.0 * np.tanh(qd[:, 0] / two_rods.WIDTH) * near, [1.0, 0.0])

    spot = formula_effect(
        "spot", "A*sign(qd)*exp(-((q-c)/w)^2)", {"c": (-1.5, 1.5, 8, "even"), "w": (0.03, 1.5, 7)}
    )
    sick = whitened_of(two_rods.motion(1, 30.0, hidden=sore))
    sick = with_prior(sick, noise=clean.problem.noise, **clean.problem.kernel.hyperparameters)
    scores = bayes_factors(sick, [Candidate(spot, 0, s) for s in spot.candidates(sick.x, 0)])
    highest = max(scores, key=lambda one: one.log_bf)
    assert refined(sick, highest).log_bf < 100.0  # a place far off, or wide
    best = best_shape(sick, scores)
    assert best.log_bf > 400.0
    assert best.candidate.shape == pytest.approx({"c": centre, "w": 0.1}, abs=0.05)


def test_middle_and_width_are_found_where_hardly_more_than_a_flank_is_seen(clean: Whitened) -> None:
    reached = float(np.max(clean.x.q[:, 0]))
    true = {"c": reached - 0.15, "w": 0.25}

    def sore(t: np.ndarray, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        near = np.exp(-(((q[:, 0] - true["c"]) / true["w"]) ** 2))
        return np.outer(2.0 * np.tanh(qd[:, 0] / two_rods.WIDTH) * near, [1.0, 0.0])

    ends: dict[str, Range] = {"c": (-reached, reached, 24, "even"), "w": (0.05, 2.0, 7)}
    spot = formula_effect("spot", "A*sign(qd)*exp(-((q-c)/w)^2)", ends)
    sick = whitened_of(two_rods.motion(1, 30.0, hidden=sore))
    sick = with_prior(sick, noise=clean.problem.noise, **clean.problem.kernel.hyperparameters)
    scores = bayes_factors(sick, [Candidate(spot, 0, s) for s in spot.candidates(sick.x, 0)])
    (truth,) = bayes_factors(sick, [Candidate(spot, 0, true)])
    best = best_shape(sick, scores)
    assert best.log_bf > truth.log_bf - 0.5
    assert best.candidate.shape == pytest.approx(true, abs=0.02)


def test_a_candidate_that_takes_the_place_of_gravity_is_rejected(clean: Whitened) -> None:
    poor = with_prior(clean, potential=1e-4 * chain_of(clean.problem).potential)
    poor = replace(poor, seconds=2.0)
    (score,) = bayes_factors(poor, [Candidate(EFFECTS["ripple"], 0, {"order": 1.0})])
    assert score.log_bf > thresholds.USED.floor
    assert log_bayes_factor_of(score, poor, without(poor)) < 0.0


def test_noise_that_was_fitted_too_large_favours_no_candidate(clean: Whitened) -> None:
    noisy = with_prior(clean, noise=30.0 * clean.problem.noise)
    (score,) = bayes_factors(clean, [Candidate(EFFECTS["drift"], 1)])
    assert log_bayes_factor_of(score, clean, noisy.system.log_evidence) > 100.0
    assert log_bayes_factor_of(score, clean, without(noisy)) < 20.0


def test_what_is_there_keeps_its_log_bayes_factor() -> None:
    whitened = whitened_of(two_rods.motion(1, 30.0, two_rods.stick))
    (score,) = bayes_factors(whitened, [Candidate(EFFECTS["stribeck"], 1, {"v_s": 0.15})])
    assert log_bayes_factor_of(score, whitened, without(whitened)) > 100.0


def test_a_parameter_that_the_motion_never_asks_for_does_no_harm(clean: Whitened) -> None:
    seen = replace(clean.x, qd=np.abs(clean.x.qd))
    whole = None if seen.whole is None else replace(seen.whole, qd=np.abs(seen.whole.qd))
    samples = replace(clean.problem.samples, x=replace(seen, whole=whole))
    forth = replace(clean, problem=clean.problem.of(samples))
    candidate = Candidate(EFFECTS["asymmetric_viscous"], 1)
    assert (candidate.columns(forth.x) == 0.0).all(axis=0).any()
    (score,) = bayes_factors(forth, [candidate])
    assert np.isfinite(log_bayes_factor_of(score, forth, without(forth)))
