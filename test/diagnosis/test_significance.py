"""Two effects that explain the same torque are compared with the same noise."""

from dataclasses import replace

import numpy as np
import pytest
import two_rods
from diagnosed_rods import FEW
from scipy.signal import lfilter
from whitened_examples import few_torques, whitened_of

from lagrangian_ff.diagnosis import diagnose
from lagrangian_ff.diagnosis.search.bayes_factor import BayesFactor, bayes_factors
from lagrangian_ff.diagnosis.search.candidates import Candidate, named
from lagrangian_ff.diagnosis.search.significance import best_of_each, lead, rivals
from lagrangian_ff.diagnosis.whitening import Whitened
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import identify
from lagrangian_ff.recording.motion import Motion

_small = few_torques(900)


@pytest.fixture(scope="module")
def stuck() -> Whitened:
    """A motion with Stribeck friction on the elbow, 0.15 rad/s wide."""
    return whitened_of(two_rods.motion(2, 30.0, two_rods.stick))


def bump(whitened: Whitened, width: float) -> BayesFactor:
    (score,) = bayes_factors(whitened, [Candidate(EFFECTS["stribeck"], 1, {"v_s": width})])
    return score


def inflated(score: BayesFactor, factor: float) -> BayesFactor:
    """Return a score whose noise is taken to scatter more."""
    f = factor * score.variance_inflation
    return replace(score, variance_inflation=f, log_bf=score.tempered(f))


def test_a_score_is_tempered_with_its_own_variance_inflation(stuck: Whitened) -> None:
    score = bump(stuck, 0.15)
    assert score.tempered(score.variance_inflation) == pytest.approx(score.log_bf)
    assert score.tempered(2.0) < 0.6 * score.tempered(1.0)


@pytest.mark.parametrize("factor", [0.5, 1.0, 3.0])
def test_of_two_that_explain_the_same_the_likelier_is_ahead(stuck: Whitened, factor: float) -> None:
    right, near = bump(stuck, 0.15), bump(stuck, 0.2)
    assert right.tempered(1.0) > near.tempered(1.0)
    known = inflated(right, factor)
    ahead, scatter = lead(known, near)
    assert ahead > 0.0
    assert lead(near, known) == pytest.approx((-ahead, scatter))


def test_what_explains_something_else_keeps_its_own_noise(stuck: Whitened) -> None:
    right = bump(stuck, 0.15)
    (wave,) = bayes_factors(stuck, [Candidate(EFFECTS["ripple"], 1, {"order": 2.0})])
    other = inflated(replace(wave, likelihood=wave.likelihood + 1.0), 3.0)
    assert lead(right, other)[0] == right.log_bf - other.log_bf


def test_noise_that_happens_to_be_known_better_rules_no_look_alike_out(stuck: Whitened) -> None:
    drag = EFFECTS["quadratic_drag"]
    right, near = bump(stuck, 0.15), bump(stuck, 0.16)
    near = replace(near, candidate=Candidate(drag, 1))
    worse = inflated(right, 2.0)
    assert near.log_bf - worse.log_bf > 20.0
    assert rivals(near, [worse]) == [worse]


def test_effects_that_are_alike_are_rivals_and_others_are_not(stuck: Whitened) -> None:
    found = best_of_each(bayes_factors(stuck, named(stuck.x, stuck.basis, (1,))))
    names = [score.candidate.source.name for score in rivals(found[0], found[1:])]
    assert "ripple" not in names
    assert "drift" not in names


def shaken(seed: int) -> Motion:
    """Return rods whose shoulder sticks a little, with noise that remembers 0.3 s."""
    motion = two_rods.motion(seed, 40.0)
    v = motion.qd[:, 0]
    sticks = np.tanh(v / two_rods.WIDTH) * np.exp(-((v / 0.2) ** 2))
    sticks *= 0.12 * np.std(motion.tau[:, 0]) / np.std(sticks)
    keeps = np.exp(-0.01 / 0.3)
    white = np.random.default_rng([22, seed]).normal(size=motion.tau.shape)
    noise = lfilter([np.sqrt(1.0 - keeps**2)], [1.0, -keeps], white, axis=0)
    tau = motion.tau + 0.08 * np.std(motion.tau, axis=0) * noise
    tau[:, 0] += sticks
    return replace(motion, tau=tau)


def test_the_truth_stays_a_rival_of_a_look_alike() -> None:
    """Stribeck friction of the load was confirmed here, and Stribeck friction ruled out."""
    first, second = shaken(122), shaken(522)
    (found,) = diagnose(identify(first, FEW).model, first, second).findings
    assert found.joint == "shoulder"
    assert "stribeck" in (found.effect.name, *found.rivals)
