"""From a model and recordings to what is missing, confirmed on motion that was not used."""

import json
from dataclasses import replace
from typing import Any

import diagnosed_rods
import numpy as np
import pytest
import two_rods
from diagnosed_rods import model_of
from whitened_examples import few_torques

from lagrangian_ff.diagnosis import (
    Diagnosis,
    Verdict,
    add,
    apply,
    diagnose,
    diagnosis_record,
    history,
    verdict,
    with_consequences,
)
from lagrangian_ff.diagnosis.confidence import Reason
from lagrangian_ff.diagnosis.consequence import Consequence
from lagrangian_ff.diagnosis.thresholds import Thresholds, using
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import EffectError, ModelError, RecordingError
from lagrangian_ff.identification import Model

_small = few_torques(1200)
stuck = diagnosed_rods.stuck


def test_the_hidden_effect_is_confirmed_with_its_size(stuck: Diagnosis) -> None:
    (finding,) = stuck.confirmed
    assert (finding.effect.name, finding.joint) == ("stribeck", "elbow")
    assert finding.parameters["F_s"].value == pytest.approx(0.6, rel=0.2)
    assert finding.shape["v_s"] == pytest.approx(0.15, rel=0.3)
    assert finding.hold_out.ratio == pytest.approx(1.0, abs=0.4)
    assert not stuck.unexplained
    assert stuck.taken_up is None


def test_below_the_floor_nothing_is_found(stuck: Diagnosis) -> None:
    with using(Thresholds(floor=1e6, event_floor=1e6)):
        assert not diagnose(stuck.model, stuck.motion, stuck.held_out).findings


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
        (False, False, {"fall": 0.0}),
        (False, False, {"deviation": 0.8}),
        (False, False, {"rise": 1.5}),
        (False, True, {"rise": 2.5}),
        (False, False, {"fall": -1.25, "deviation": 0.8}),
        (False, True, {"fall": -1.25, "deviation": 0.6}),
    ],
    ids=["falls", "stays", "chance", "others rise", "others surely", "rises", "surely"],
)
def test_an_addition_is_worth_it_if_the_error_surely_falls(
    stuck: Diagnosis, worth: bool, harms: bool, change: dict[str, Any]
) -> None:
    blocks = np.array([1.0, 1.0])
    errors = {"whole_before": 1.0, "whole_after": 0.5, "every_before": 2.0, "every_after": 1.8}
    given = {**errors, "fall": 0.75, **change}
    made = Consequence(stuck.model, "elbow", blocks, blocks, 0.5 * blocks, **given)
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
