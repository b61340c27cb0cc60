"""What a candidate is worth is the evidence with it over the best without it."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import two_rods
from ground_examples import begun, dense, ground_of, quickly
from scipy.stats import multivariate_normal

from lagrangian_ff.diagnosis.ground import Ground, sharpen
from lagrangian_ff.diagnosis.ground.ground import Extra
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.diagnosis.search.forward import FLOOR
from lagrangian_ff.diagnosis.search.gain import PRIOR_SHARE, scores
from lagrangian_ff.diagnosis.search.worth import evidence_without, worth_of
from lagrangian_ff.effects import EFFECTS


@pytest.fixture(autouse=True, scope="module")
def _small() -> Iterator[None]:
    with quickly(1000):
        yield


@pytest.fixture(scope="module")
def clean() -> Ground:
    """Return the ground of a motion in which nothing is hidden."""
    return ground_of(two_rods.motion(1, 30.0))


def with_prior(ground: Ground, **changed: np.ndarray) -> Ground:
    """The ground with another kernel or other noise."""
    noise = changed.pop("noise", ground.prior.noise)
    prior = replace(ground.prior, kernel=ground.prior.kernel.replace(**changed), noise=noise)
    return ground.relaid(prior)


def without(ground: Ground) -> float:
    """Return the best log evidence that is reached without a candidate."""
    return evidence_without(ground, sharpen(ground, ground.basis, ground.extra))


def test_it_is_a_difference_of_log_evidence(clean: Ground) -> None:
    """Against the definition, with dense matrices, on a few samples and without a basis."""
    small = begun(clean, 40)
    candidate = Candidate(EFFECTS["asymmetric_viscous"], 1)
    (score,) = scores(small, [candidate])
    columns = candidate.columns(small.seen)
    amplitude = small.relaid(extra=(Extra(1, columns),)).system.amplitude
    scale = PRIOR_SHARE * small.spread[1] / np.sqrt(np.mean(columns**2, axis=0))
    full = np.zeros((40, 2, columns.shape[1]))
    full[:, 1] = columns * scale / small.prior.unit[1]
    flat = full.reshape(80, -1)
    gram, y = dense(small)
    expected = multivariate_normal.logpdf(y, cov=amplitude * gram + flat @ flat.T)
    assert worth_of(score, small, 0.0) * score.inflation == pytest.approx(expected, abs=1e-6)


def test_a_candidate_that_takes_the_place_of_gravity_is_worth_nothing(clean: Ground) -> None:
    poor = with_prior(clean, potential=1e-4 * clean.prior.kernel.potential)
    (score,) = scores(poor, [Candidate(EFFECTS["ripple"], 0, {"order": 1.0})])
    assert score.gain > FLOOR
    assert worth_of(score, poor, without(poor)) < 0.0


def test_noise_that_was_chosen_too_large_gives_nothing_its_worth(clean: Ground) -> None:
    noisy = with_prior(clean, noise=30.0 * clean.prior.noise)
    (score,) = scores(clean, [Candidate(EFFECTS["drift"], 1)])
    assert worth_of(score, clean, noisy.system.log_evidence) > 100.0
    assert worth_of(score, clean, without(noisy)) < 20.0


def test_what_is_there_keeps_its_worth() -> None:
    ground = ground_of(two_rods.motion(1, 30.0, two_rods.stick))
    (score,) = scores(ground, [Candidate(EFFECTS["stribeck"], 1, {"v_s": 0.15})])
    worth = worth_of(score, ground, without(ground))
    assert worth > 100.0


def test_a_parameter_that_the_motion_never_asks_for_does_no_harm(clean: Ground) -> None:
    seen = replace(clean.seen, qd=np.abs(clean.seen.qd))
    whole = None if seen.whole is None else replace(seen.whole, qd=np.abs(seen.whole.qd))
    forth = replace(clean, seen=replace(seen, whole=whole))
    candidate = Candidate(EFFECTS["asymmetric_viscous"], 1)
    assert (candidate.columns(forth.seen) == 0.0).all(axis=0).any()
    (score,) = scores(forth, [candidate])
    assert np.isfinite(worth_of(score, forth, without(forth)))
