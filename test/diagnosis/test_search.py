"""Log Bayes factors agree with their definition, and the search finds what is hidden."""

from dataclasses import replace

import numpy as np
import pytest
import two_rods
from scipy.stats import multivariate_normal
from whitened_examples import begun, clean_rods, dense, few_torques, friction, whitened_of

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.search.backward import Needed, superfluous
from lagrangian_ff.diagnosis.search.bayes_factor import PRIOR_SHARE, BayesFactor, bayes_factors
from lagrangian_ff.diagnosis.search.candidates import Candidate, named, nonparametric
from lagrangian_ff.diagnosis.search.change import change_of
from lagrangian_ff.diagnosis.search.forward import search
from lagrangian_ff.diagnosis.search.judging import possible_first
from lagrangian_ff.diagnosis.search.significance import MaximumNull, best_of_each
from lagrangian_ff.diagnosis.whitening import Whitened
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.recording.motion import Motion, concatenate

_small = few_torques(1000)


clean = pytest.fixture(scope="module")(clean_rods)


def test_the_log_bayes_factor_is_the_difference_of_log_evidence(clean: Whitened) -> None:
    """Against the definition, with dense matrices, on a few samples and without a basis."""
    small = begun(clean, 40)
    candidate = Candidate(EFFECTS["quadratic_drag"], 1)
    (score,) = bayes_factors(small, [candidate])
    columns = candidate.columns(small.x)
    scale = PRIOR_SHARE * small.spread[1] / np.sqrt(np.mean(columns**2))
    full = np.zeros((40, 2))
    full[:, 1] = columns[:, 0] * scale / small.problem.unit[1]
    gram, y = dense(small)
    gram *= small.amplitude**2
    with_it = multivariate_normal.logpdf(y, cov=gram + np.outer(full, full))
    expected = with_it - multivariate_normal.logpdf(y, cov=gram)
    assert score.tempered(1.0) == pytest.approx(expected, abs=1e-6)


def test_what_the_model_has_explains_nothing_more(clean: Whitened) -> None:
    twins = [Candidate(EFFECTS[name], joint) for name in ("viscous", "offset") for joint in (0, 1)]
    twins.append(Candidate(EFFECTS["asymmetric_coulomb"], 0))
    for score in bayes_factors(clean, twins):
        assert score.log_bf <= 1e-6
        assert score.survival < 1e-4


def test_clean_motion_gives_no_candidate_more_than_chance(clean: Whitened) -> None:
    found = [
        *bayes_factors(
            clean, [*named(clean.x, clean.basis, (0, 1)), *nonparametric(clean.x, (0, 1))]
        )
    ]
    lasting = [score for score in found if not score.once]
    null = MaximumNull.of(lasting)
    best = max(lasting, key=lambda score: score.log_bf)
    assert best.log_bf < max(8.0, null.threshold)
    assert 0.0 < null.p_value(null.threshold) < 0.1
    assert null.p_value(1e9) < 0.01


def test_chance_is_reproducible_from_its_seed(clean: Whitened) -> None:
    found = list(bayes_factors(clean, named(clean.x, clean.basis, (0,))))
    np.testing.assert_array_equal(
        MaximumNull.of(found, 3).largest, MaximumNull.of(found, 3).largest
    )


def test_a_hidden_effect_comes_first_at_its_true_shape() -> None:
    whitened = whitened_of(two_rods.motion(2, 30.0, two_rods.stick))
    found = best_of_each(bayes_factors(whitened, named(whitened.x, whitened.basis, (0, 1))))
    assert found[0].candidate.key == ("stribeck", 1)
    assert found[0].log_bf > 30.0
    assert found[0].candidate.shape["v_s"] == pytest.approx(0.15, rel=0.5)


def test_a_step_that_is_too_wide_is_no_stribeck_friction(clean: Whitened) -> None:
    """As it is where it was fitted while other friction was missing."""
    wide = clean.explaining(friction(0.15), ())
    bump = Candidate(EFFECTS["stribeck"], 1, {"v_s": 0.1})
    assert bayes_factors(wide, [bump])[0].log_bf > 2.0 * thresholds.USED.floor
    assert not search(wide).steps


def test_a_shape_at_an_end_comes_after_an_effect_that_may_be(clean: Whitened) -> None:
    stribeck, share = EFFECTS["stribeck"], thresholds.USED.possible_share
    ends = max(stribeck.candidates(clean.x, 1), key=lambda shape: shape["v_s"])
    candidates = [Candidate(stribeck, 1, ends), Candidate(EFFECTS["quadratic_drag"], 1)]
    at_an_end, drag = bayes_factors(clean, candidates)
    first = replace(at_an_end, log_bf=100.0)
    for nats, expected in ((120.0 * share, drag), (80.0 * share, at_an_end)):
        names = possible_first([first, replace(drag, log_bf=nats)], clean.x)
        assert names[0].candidate == expected.candidate
        assert len(names) == 2


def test_nothing_takes_hold_of_a_clean_arm(clean: Whitened) -> None:
    assert change_of(clean) is None


def test_a_load_taken_up_is_dated() -> None:
    motion = two_rods.motion(4, 30.0, load_since=14.0)
    change = change_of(whitened_of(motion))
    assert change is not None
    assert change.effect.name == "payload"
    assert change.since == pytest.approx(14.0, abs=0.1)
    assert change.log_bayes_factor > 50.0
    low, high = change.since_range
    assert low < 14.0 < high
    assert low < change.since < high
    assert high - low < 5.0


@pytest.mark.parametrize("seed", [2, 5])
def test_a_touch_near_the_beginning_is_no_load_from_then_on(seed: int) -> None:
    motion = two_rods.motion(seed, 30.0)
    touched = (motion.time >= 3.0) & (motion.time < 3.5)
    motion = replace(motion, tau=motion.tau + 1.0 * touched[:, None])
    assert change_of(whitened_of(motion)) is None


def test_several_recordings_have_no_common_moment() -> None:
    motion = concatenate([two_rods.motion(seed, 30.0, load_since=14.0) for seed in (4, 5)])
    assert change_of(whitened_of(motion)) is None


def test_a_cause_found_already_is_preferred_to_a_new_one(clean: Whitened) -> None:
    """Unless the new one explains clearly more."""
    (score, *_) = bayes_factors(clean, named(clean.x, clean.basis, (0,)))
    gear = EFFECTS["elasticity"]

    def of(joint: float, gain: float) -> BayesFactor:
        shape = {"of": joint, "f": 4.0, "z": 0.1}
        return replace(score, candidate=Candidate(gear, 0, shape), log_bf=gain)

    causes = frozenset({("elasticity", 1)})
    for new, known, chosen in ((100.0, 90.0, 1.0), (100.0, 30.0, 0.0)):
        (best,) = best_of_each([of(0.0, new), of(1.0, known)], causes)
        assert best.candidate.shape["of"] == chosen
    (best,) = best_of_each([of(0.0, 100.0), of(1.0, 90.0)])
    assert best.candidate.shape["of"] == 0.0


def test_plain_friction_comes_before_friction_with_a_bend() -> None:
    """A joint whose model has no friction at all lacks Coulomb's first, then the viscous."""
    motion = two_rods.motion(1, 30.0)
    found = search(whitened_of(motion, Basis(())), steps=4)
    names = [step.score.candidate.key for step in found.steps]
    assert {("coulomb", 0), ("coulomb", 1)} <= set(names)
    assert {name for name, _ in names} <= {"coulomb", "viscous"}
    assert all(not step.rivals for step in found.steps)


def test_friction_that_every_joint_has_comes_before_any_that_changes_with_position() -> None:
    """Though a curve over position, which holds it, explains more."""

    def uneven(
        t: two_rods.Floats, q: two_rods.Floats, qd: two_rods.Floats, qdd: two_rods.Floats
    ) -> two_rods.Floats:
        more = 1.0 * np.sin(q[:, 1]) * np.tanh(qd[:, 1] / two_rods.WIDTH)
        return np.stack([np.zeros_like(more), more], axis=1)

    motion = two_rods.motion(1, 30.0, uneven)
    found = search(whitened_of(motion, Basis(())), steps=6)
    on_elbow = [name for name, joint in (s.score.candidate.key for s in found.steps) if joint]
    assert on_elbow[0] in ("coulomb", "viscous")
    assert "position_friction" in on_elbow


def test_friction_of_a_load_that_is_all_inertia_is_found() -> None:
    """For rods that lie flat, only the friction separates the load's inertia from the rotors'."""
    motion = two_rods.motion(1, 40.0)
    still = np.zeros_like(motion.q)
    weight = two_rods.rods(motion.q, still, still)
    link = two_rods.rods(motion.q, motion.qd, motion.qdd) - weight
    tau = motion.tau - weight + motion.qdd * np.array([3.0, 0.05])
    tau[:, 0] += 0.3 * np.abs(link[:, 0]) * np.tanh(motion.qd[:, 0] / two_rods.WIDTH)
    found = search(whitened_of(replace(motion, tau=tau)), steps=1)
    assert found.steps[0].score.candidate.key == ("load_friction", 0)


def test_an_effect_that_leaves_nothing_of_a_curve_is_that_curve() -> None:
    """However much the curve gains; one that leaves a part of it is not."""
    with thresholds.using(replace(thresholds.USED, name_share=10.0)):
        (bump,) = search(whitened_of(two_rods.motion(2, 30.0, two_rods.stick))).steps
        (spot, *_) = search(whitened_of(two_rods.motion(2, 30.0, two_rods.sore_spot))).steps
    assert bump.score.candidate.key == ("stribeck", 1)
    assert bump.free is not None
    assert not spot.named
    assert spot.score.candidate.joint == 0


def test_a_tie_with_the_null_does_not_exceed_it() -> None:
    null = MaximumNull(np.full(400, 225.0))
    rounded = 225.0 * (1.0 + 1e-9)
    assert not null.exceeded_by(rounded)
    assert null.p_value(rounded) == 1.0
    assert null.exceeded_by(226.0)
    assert null.p_value(226.0) == 1.0 / 401.0


def test_the_threshold_is_where_the_p_value_reaches_the_level() -> None:
    null = MaximumNull(np.arange(400.0))
    over = null.threshold + 0.5
    assert null.p_value(over) <= thresholds.USED.level < null.p_value(null.threshold)
    assert null.exceeded_by(over)
    assert not null.exceeded_by(null.threshold)


def test_what_is_needed_too_little_is_taken_out_again() -> None:
    gear, ripple = Needed(0, 1, 1800.0), Needed(1, 1, 40.0)
    assert superfluous([gear, Needed(1, 1, thresholds.USED.floor - 1.0)]) == 1
    # Forty nats are much alone, and little beside eighteen hundred on the same joint.
    assert superfluous([gear, ripple]) == 1
    assert superfluous([gear, ripple._replace(joint=0)]) is None
    assert superfluous([gear, ripple._replace(log_bf=100.0)]) is None
    assert superfluous([gear, ripple, Needed(2, 0, thresholds.USED.floor - 12.0)]) == 2
    # What other motion confirmed: little of it is to be seen, which is not against it.
    assert superfluous([gear, ripple._replace(log_bf=1.0, stands=True)]) is None
    assert superfluous([gear, ripple._replace(log_bf=-1.0, stands=True)]) == 1


def bumped(share: float) -> Motion:
    """Return a motion with a share of the usual bump at low speed."""

    def faint(
        t: two_rods.Floats, q: two_rods.Floats, qd: two_rods.Floats, qdd: two_rods.Floats
    ) -> two_rods.Floats:
        return share * two_rods.stick(t, q, qd, qdd)

    return two_rods.motion(2, 30.0, faint)


def test_what_nearly_stands_out_is_judged_with_the_hyperparameters_that_suit_it() -> None:
    """Hyperparameters that were fitted without an effect explain a part of it."""
    (step,) = search(whitened_of(bumped(0.1))).steps
    assert step.score.candidate.key == ("stribeck", 1)
    assert step.first_log_bf < thresholds.USED.floor < step.score.log_bf
    with thresholds.using(replace(thresholds.USED, near_floor=1.0)):
        assert not search(whitened_of(bumped(0.1))).steps


def test_what_other_motion_confirmed_is_a_step_unless_motion_speaks_against_it() -> None:
    """A twentieth of the bump is too small to be found, but it is there."""
    bump = Term(EFFECTS["stribeck"], 1, {"v_s": 0.15})
    known = Basis((*friction().terms, bump))
    wave = Basis((*friction().terms, Term(EFFECTS["ripple"], 1, {"order": 7.0})))
    motion = bumped(0.05)
    assert not search(whitened_of(motion)).steps
    (step,) = search(whitened_of(motion, known), known=1).steps
    assert step.score.candidate.key == ("stribeck", 1)
    assert step.stands
    assert 0.0 < step.score.log_bf < thresholds.USED.floor
    assert not search(whitened_of(motion, wave), known=1).steps
