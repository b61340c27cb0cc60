"""The verdict on each effect found, and what puts it in doubt."""

from dataclasses import replace

import diagnosed_rods
import numpy as np
import pytest
import two_rods
from diagnosed_rods import FEW, model_of
from whitened_examples import few_torques

from lagrangian_ff.diagnosis import Diagnosis, Finding, Verdict, diagnose
from lagrangian_ff.diagnosis.confidence import Reason
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.diagnosis.search.forward import Search, search
from lagrangian_ff.diagnosis.search.hold_out import judge_hold_out
from lagrangian_ff.diagnosis.thresholds import Effort, Thresholds, using
from lagrangian_ff.diagnosis.verdicts import doubt_of, findings_of
from lagrangian_ff.diagnosis.whitening import fit, whiten
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import Model, identify
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.recording.motion import WITHOUT_GRAVITY, Motion

_small = few_torques(1200)
stuck, stuck_search = diagnosed_rods.stuck, diagnosed_rods.stuck_search


@pytest.mark.parametrize(
    ("limits", "reason"),
    [
        (Thresholds(size_ratio=(3.0, 4.0)), Reason.OTHER_SIZE),
        (Thresholds(held_out_share=1.1), Reason.NOT_HELD_OUT),
        (Thresholds(fewest_groups=99), Reason.TOO_SHORT),
        (Thresholds(large_rest=-1.0), Reason.LARGE_REST),
    ],
)
def test_a_threshold_decides_the_verdict(
    stuck: Diagnosis, stuck_search: Search, limits: Thresholds, reason: Reason
) -> None:
    judged = stuck_search, stuck.held_out, stuck.model, None
    assert findings_of(*judged)[0].verdict is Verdict.CONFIRMED
    with using(limits):
        (finding,) = findings_of(*judged)
    assert finding.verdict is Verdict.SUGGESTED
    assert finding.doubt is not None
    assert finding.doubt.reason is reason


def test_an_effect_and_a_curve_are_compared_by_the_noise_that_is_left() -> None:
    """The drag is found first, while the sore spot still counts as noise, and so scores low."""
    first, second = (two_rods.motion(seed, hidden=two_rods.thick_and_sore) for seed in (1, 2))
    with using(Thresholds(large_rest=1.0), Effort(rows=1200)):
        found = diagnose(model_of(two_rods.thick_and_sore), first, second)
    (finding,) = found.findings
    (left,) = found.unexplained
    assert (finding.effect.name, finding.joint) == ("quadratic_drag", "shoulder")
    assert finding.log_bayes_factor < left.log_bayes_factor
    assert finding.confirmed


def sprung(
    t: two_rods.Floats, q: two_rods.Floats, qd: two_rods.Floats, qdd: two_rods.Floats
) -> two_rods.Floats:
    """A spring in the elbow."""
    return np.stack([np.zeros(len(t)), 3.0 * q[:, 1]], axis=1)


@pytest.fixture(scope="module")
def with_spring() -> tuple[Model, Search, Finding]:
    """Return a model, and the search and the finding of a spring that it lacks."""
    model = identify(two_rods.motion(1), replace(FEW, model="chain+fri")).model
    first, second = (two_rods.motion(seed, hidden=sprung) for seed in (1, 2))
    (finding,) = diagnose(model, first, second).confirmed
    found = search(fit(first, model.inputs_of(first), model.basis))
    return model, found, finding


def ends(finding: Finding) -> tuple[two_rods.Floats, two_rods.Floats]:
    """Return the ends of the intervals of a finding's parameters."""
    low, high = np.array([(one.low, one.high) for one in finding.parameters.values()]).T
    return low, high


def test_a_spring_is_found(with_spring: tuple[Model, Search, Finding]) -> None:
    finding = with_spring[2]
    assert (finding.effect.name, finding.joint) == ("spring", "elbow")
    low, high = ends(finding)
    assert low[0] < 3.0 < high[0]


def test_a_spring_is_missing_only_where_gravity_is_not_free(
    with_spring: tuple[Model, Search, Finding],
) -> None:
    _, found, _ = with_spring
    free = identify(two_rods.motion(1), replace(FEW, model="chain_rbf+fri")).model
    assert free.kernel.free
    doubt = doubt_of(found, found.steps[0], free)
    assert doubt is not None
    assert doubt.reason is Reason.ABSORBED
    assert "has this torque already" in doubt.words


def test_a_shape_that_ends_where_nature_ends_it_is_in_doubt() -> None:
    first, model = two_rods.motion(1, hidden=two_rods.stick), model_of(None)
    found = search(fit(first, model.inputs_of(first), model.basis))
    (step,) = [step for step in found.steps if step.score.candidate.key == ("stribeck", 1)]
    assert doubt_of(found, step, model) is None
    candidate = step.score.candidate
    tried = candidate.effect.candidates(found.whitened.x, 1)
    for end in (min(one["v_s"] for one in tried), max(one["v_s"] for one in tried)):
        score = replace(step.score, candidate=replace(candidate, shape={"v_s": end}))
        doubt = doubt_of(found, replace(step, score=score), model)
        assert doubt is not None
        assert doubt.reason is Reason.AT_END
        assert f"its v_s (Stribeck velocity) is {end:.3g} rad/s" in doubt.words


def stick_and_swing(
    t: two_rods.Floats, q: two_rods.Floats, qd: two_rods.Floats, qdd: two_rods.Floats
) -> two_rods.Floats:
    """Dry friction of the elbow that swings by 2 N·m within a turn, and its stick."""
    torque = two_rods.stick(t, q, qd, qdd)
    swing = 1.5 * (np.cos(q[:, 1]) - np.sin(q[:, 1])) * np.tanh(qd[:, 1] / two_rods.WIDTH)
    return torque + np.stack([np.zeros(len(t)), swing], axis=1)


def weightless(motion: Motion) -> Motion:
    """Return a motion whose driver took the torque of gravity off."""
    still = np.zeros_like(motion.q)
    conditioning = {**motion.conditioning, "effort": WITHOUT_GRAVITY}
    weight = two_rods.rods(motion.q, still, still)
    return replace(motion, tau=motion.tau - weight, conditioning=conditioning)


def test_friction_over_position_may_be_that_of_a_load_whose_weight_the_effort_lacks() -> None:
    model = identify([weightless(two_rods.motion(1))], replace(FEW, model="chain+fri")).model
    first, second = (weightless(two_rods.motion(s, hidden=stick_and_swing)) for s in (1, 2))
    found = diagnose(model, first, second)
    (finding,) = (one for one in found.findings if one.effect.name == "position_friction")
    assert "load_friction" in finding.rivals
    assert not finding.confirmed


def test_what_is_not_there_does_not_take_a_larger_effect_with_it() -> None:
    """A smaller one that other motion refutes is fitted to it before the larger is judged."""
    model = model_of(two_rods.stick)
    first, second = (two_rods.motion(seed, hidden=two_rods.stick) for seed in (1, 2))
    found = search(fit(first, model.inputs_of(first), model.basis))
    (step,) = found.steps
    wrong = Candidate(EFFECTS["position_friction"], 1)
    smaller = replace(step, score=replace(step.score, candidate=wrong, log_bf=25.0))
    # As found on motion with friction that the second recording does not have.
    rough = two_rods.motion(1, hidden=stick_and_swing)
    basis = Basis((*found.whitened.basis.terms, wrong.term()))
    before = found.whitened
    whitened = whiten(rough, before.index, before.seconds, before.inputs, before.problem)
    whitened = whitened.explaining(basis, ())
    found = replace(found, steps=(step, smaller), whitened=whitened)
    views = judge_hold_out(found, second, None)
    assert views[0][1].holds
    assert not views[1][1].holds
