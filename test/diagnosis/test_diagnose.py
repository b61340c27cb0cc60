"""From a model and recordings to what is missing, confirmed on motion that was not used."""

import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import two_rods
from diagnosed_rods import FEW, diagnosed, search_of

from lagrangian_ff.diagnosis import (
    Diagnosis,
    Finding,
    Verdict,
    add,
    apply,
    diagnose,
    diagnosis_record,
    history,
    verdict,
    with_consequences,
)
from lagrangian_ff.diagnosis.consequence import Consequence
from lagrangian_ff.diagnosis.diagnose import doubt_of, findings_of
from lagrangian_ff.diagnosis.results import Reason
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.diagnosis.search.forward import Search, search
from lagrangian_ff.diagnosis.search.hold_out import judge_hold_out
from lagrangian_ff.diagnosis.thresholds import Effort, Thresholds, using
from lagrangian_ff.diagnosis.whitening import fit, whiten
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import EffectError, ModelError, RecordingError
from lagrangian_ff.identification import Model, identify
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.recording.motion import WITHOUT_GRAVITY, Motion


@pytest.fixture(autouse=True, scope="module")
def _small() -> Iterator[None]:
    with using(effort=Effort(rows=1200)):
        yield


def model_of(hidden: two_rods.Hidden | None, seed: int = 1) -> Model:
    return identify(two_rods.motion(seed, hidden=hidden), FEW).model


@pytest.fixture(scope="module")
def stuck() -> Diagnosis:
    """Return the diagnosis of an arm whose elbow sticks, confirmed on a second recording."""
    return diagnosed(two_rods.stick)


def test_the_hidden_effect_is_confirmed_with_its_size(stuck: Diagnosis) -> None:
    (finding,) = stuck.confirmed
    assert (finding.effect.name, finding.joint) == ("stribeck", "elbow")
    assert finding.parameters["F_s"].value == pytest.approx(0.6, rel=0.2)
    assert finding.shape["v_s"] == pytest.approx(0.15, rel=0.3)
    assert finding.hold_out.ratio == pytest.approx(1.0, abs=0.4)
    assert not stuck.unexplained
    assert stuck.taken_up is None


@pytest.fixture(scope="module")
def stuck_search(stuck: Diagnosis) -> Search:
    """Return the search behind `stuck`."""
    return search_of(stuck)


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


def test_below_the_floor_nothing_is_found(stuck: Diagnosis) -> None:
    with using(Thresholds(floor=1e6, event_floor=1e6)):
        assert not diagnose(stuck.model, stuck.motion, stuck.held_out).findings


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


def test_what_happened_once_is_never_added(stuck: Diagnosis) -> None:
    (finding,) = stuck.findings
    once = replace(finding, effect=EFFECTS["contact"], shape={"t0": 1.0, "length": 2.0})
    assert once.verdict is Verdict.CONFIRMED
    assert apply(replace(stuck, findings=(once,))) is stuck.model


def test_the_load_of_another_model_is_no_part_of_a_finding() -> None:
    mesh = EFFECTS["gear_mesh"]
    assert mesh.transferable({"order": 6.0, "Jr": 0.02}) == {"order": 6.0}


def test_the_record_is_json_and_complete(stuck: Diagnosis) -> None:
    tried = with_consequences(stuck)
    record = json.loads(json.dumps(diagnosis_record(tried), allow_nan=False))
    assert "stribeck on elbow" in record["verdict"]
    (found,) = [one for one in record["findings"] if one["verdict"] == "confirmed"]
    assert found["error_after"] < found["error_before"]
    assert found["evidence_gain"] > 20.0
    assert 0.0 < found["p_value"] < 0.05
    assert found["parameters"]["F_s"]["unit"] == "N·m"
    assert {"effect", "joint", "next_motion"} <= set(record["not_observable"][0])
    assert len(found["signature"]["x"]) == len(found["signature"]["effect"])


def test_what_is_confirmed_is_added_and_the_history_tells_why(stuck: Diagnosis) -> None:
    model = apply(stuck)
    assert model.name == "chain+fri+stribeck@elbow"
    steps = history(model)["steps"]
    assert isinstance(steps, list)
    assert [step["added"] for step in steps] == ["identified", "stribeck on elbow"]
    assert steps[1]["verdict"] == "confirmed"
    assert steps[1]["joints"]["elbow"]["after"] < steps[1]["joints"]["elbow"]["before"]
    unseen = two_rods.motion(3, hidden=two_rods.stick)

    def error(one: Model) -> float:
        left = unseen.tau - one.predict(unseen.q, unseen.qd, unseen.qdd, time=unseen.time)
        return float(np.sqrt(np.mean(left[:, 1] ** 2)))

    assert error(model) < error(stuck.model)


def test_what_does_not_lower_the_error_is_not_added() -> None:
    """The model keeps recordings from before the elbow stuck: refitted, it learns nothing of it."""
    first, second = (two_rods.motion(seed, hidden=two_rods.stick) for seed in (1, 2))
    found = diagnose(model_of(None, 5), first, second)
    assert [one.name for one in found.confirmed] == ["stribeck on elbow"]
    tried = with_consequences(found)
    assert not tried.confirmed
    (finding,) = tried.findings
    assert finding.doubt is not None
    assert finding.doubt.reason is Reason.NO_HELP
    assert finding.hold_out.holds
    assert "stribeck on elbow is there" in verdict(tried)
    assert "does not lower the error of this model" in verdict(tried)
    assert apply(found) is found.model
    assert apply(tried) is found.model


@pytest.mark.parametrize("rivals", [(), ("delay",)], ids=["confirmed", "ambiguous"])
@pytest.mark.parametrize(
    "names", [("hysteresis", "asymmetric_coulomb"), ("offset", "asymmetric_viscous", "spring")]
)
def test_whatever_is_still_claimed_lowers_the_error(
    stuck: Diagnosis, names: tuple[str, ...], rivals: tuple[str, ...]
) -> None:
    """Claims of what is not there go, in company of one that is, and so does what leans on them."""
    (true,) = stuck.confirmed
    false = [
        replace(true, effect=EFFECTS[name], joints=(joint,), shape={}, rivals=rivals)
        for name in names
        for joint in stuck.model.joints
    ]
    tried = with_consequences(replace(stuck, findings=(*false, true)))
    claimed = [one for one in tried.findings if one.doubt is None and one.consequence]
    assert true.name in [one.name for one in claimed]
    assert all(one.consequence is not None and one.consequence.worth for one in claimed)
    assert len(claimed) < len(tried.findings)


@pytest.mark.parametrize(
    ("worth", "harms", "change"),
    [
        (True, False, {}),
        (False, False, {"whole_after": 1.0}),
        (False, False, {"deviation": 0.8}),
        (False, False, {"rise": 1.5}),
        (False, True, {"rise": 2.5}),
        (False, False, {"whole_after": 1.5, "deviation": 0.8}),
        (False, True, {"whole_after": 1.5, "deviation": 0.6}),
    ],
    ids=["falls", "stays", "chance", "others rise", "others surely", "rises", "surely"],
)
def test_an_addition_is_worth_it_if_the_error_surely_falls(
    stuck: Diagnosis, worth: bool, harms: bool, change: dict[str, Any]
) -> None:
    blocks = np.array([1.0, 1.0])
    errors = {"whole_before": 1.0, "whole_after": 0.5, "every_before": 2.0, "every_after": 1.8}
    made = Consequence(stuck.model, blocks, blocks, 0.5 * blocks, **{**errors, **change})
    assert (made.worth, made.harms) == (worth, harms)


def test_nothing_is_added_twice(stuck: Diagnosis) -> None:
    model = apply(stuck)
    with pytest.raises(ModelError, match="has stribeck on elbow already"):
        add(model, "stribeck", "elbow")
    with pytest.raises(ModelError, match="under another name"):
        add(model, "asymmetric_coulomb", "elbow")
    with pytest.raises(ModelError, match="no joint 'knee'"):
        add(model, "stribeck", "knee")
    with pytest.raises(EffectError, match="no effect 'magic'"):
        add(model, "magic", "elbow")


def test_once_added_it_is_not_missing_any_more(stuck: Diagnosis) -> None:
    again = diagnose(apply(stuck), stuck.motion, stuck.held_out)
    assert not again.confirmed


def test_a_recording_of_another_arm_is_refused_with_both_lists(stuck: Diagnosis) -> None:
    turned = replace(stuck.motion, joints=("shoulder", "wrist"), source="other")
    for first, unseen in ((turned, stuck.motion), (stuck.motion, [stuck.motion, turned])):
        with pytest.raises(ModelError, match=r"shoulder, elbow; other holds shoulder, wrist"):
            diagnose(stuck.model, first, unseen)


def test_a_clean_arm_lacks_nothing() -> None:
    motions = [two_rods.motion(seed) for seed in (5, 6)]
    found = diagnose(model_of(None, 5), motions[0], motions[1])
    assert not found.confirmed
    assert not found.unexplained
    assert "noise" in verdict(found)


def test_one_recording_is_confirmed_on_its_end() -> None:
    motion = two_rods.motion(1, 60.0, two_rods.stick)
    found = diagnose(model_of(two_rods.stick), motion)
    assert not found.separate
    assert found.held_out.time[0] > found.motion.time[-1]
    assert found.findings[0].effect.name == "stribeck"


def test_a_motion_too_short_to_rule_out_chance_has_no_verdict(stuck: Diagnosis) -> None:
    """Where the noise remembers long, few blocks are independent: chance makes anything of them."""
    motion = two_rods.motion(1, hidden=two_rods.stick)
    with using(Thresholds(fewest_blocks=1000)):
        found = diagnose(stuck.model, motion, stuck.held_out)
    assert not found.findings
    assert found.ranking[0].name == "stribeck"
    assert found.wanting > 100.0
    said = verdict(found)
    assert "too little motion" in said
    assert "stribeck on elbow" in said
    assert f"{found.wanting:.0f} s more" in said


def test_a_load_taken_up_is_dated_and_confirmed_by_one_that_takes_it_up_again() -> None:
    model = model_of(None)
    first, second, clean = (
        two_rods.motion(seed, load_since=since)
        for seed, since in ((2, 14.0), (3, 20.0), (4, np.inf))
    )
    found = diagnose(model, first, second).taken_up
    assert found is not None
    assert (found.effect.name, found.verdict) == ("payload", Verdict.CONFIRMED)
    assert set(found.joints) == {"shoulder", "elbow"}
    ((name, moment),) = found.parameters.items()
    assert (name, moment.unit) == ("t0", "s")
    assert moment.low - 0.5 < 14.0 < moment.high + 0.5
    assert found.shape == {"t0": moment.value}
    unsure = diagnose(model, first, clean).taken_up
    assert unsure is not None
    assert unsure.doubt is not None
    assert unsure.doubt.reason is Reason.NOT_AGAIN


def test_too_little_motion_is_said_with_what_to_do() -> None:
    with pytest.raises(RecordingError, match="not observable here; record half a minute"):
        diagnose(model_of(None), two_rods.motion(1, 4.0))


def test_results_are_reproducible(stuck: Diagnosis) -> None:
    again = diagnose(stuck.model, stuck.motion, stuck.held_out)
    gains = [finding.log_bayes_factor for finding in stuck.findings]
    assert [finding.log_bayes_factor for finding in again.findings] == gains
