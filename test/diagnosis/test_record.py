"""What readers of a diagnosis see of it: the verdict, where a finding is, and the JSON."""

import json
from dataclasses import replace

import pytest
from diagnosis_examples import (
    JOINTS,
    changed,
    consequence,
    diagnosis,
    doubt,
    fault,
    finding,
    full_run,
    model,
    run,
    taken_up,
)

from lagrangian_ff.diagnosis import Changed, Round, Verdict, run_record, verdict
from lagrangian_ff.diagnosis.record import saved_findings
from lagrangian_ff.diagnosis.results import Change, Found, Remainder, Unexplained
from lagrangian_ff.effects import Over, curve_over
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.record_json import to_json

ARM = ("base", "elbow", "wrist", "hand")


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (finding(), Verdict.CONFIRMED),
        (finding(rivals=("delay",)), Verdict.AMBIGUOUS),
        (finding(rivals=("delay",), doubt=doubt()), Verdict.SUGGESTED),
        (taken_up(), Verdict.CONFIRMED),
        (taken_up(doubt=doubt()), Verdict.SUGGESTED),
    ],
)
def test_a_doubt_weighs_more_than_a_rival(found: Found, expected: Verdict) -> None:
    assert found.verdict is expected
    assert found.confirmed == (expected is Verdict.CONFIRMED)


def test_a_finding_says_whose_gear_it_is_if_it_is_felt_elsewhere() -> None:
    assert finding(joint="wrist", cause="elbow").place(ARM) == "wrist (gear of elbow)"
    assert finding(joint="wrist", cause="wrist").place(ARM) == "wrist"
    assert taken_up(joints=ARM).place(ARM) == "every joint"


def test_what_was_found_is_listed_by_verdict_and_then_by_evidence() -> None:
    weak, strong = finding(log_bayes_factor=30.0), finding("ripple", log_bayes_factor=90.0)
    unsure = finding("spring", log_bayes_factor=500.0, doubt=doubt())
    found = diagnosis(findings=(strong, weak, unsure), taken_up=taken_up(log_bayes_factor=60.0))
    assert [one.log_bayes_factor for one in found.found] == [90.0, 60.0, 30.0, 500.0]


def test_the_verdict_says_what_is_sure_what_is_not_and_what_is_left() -> None:
    both = (finding(), finding("ripple", "shoulder"))
    said = verdict(diagnosis(findings=both))
    assert "stribeck on elbow and ripple on shoulder: the error over all joints falls" in said
    worse = verdict(diagnosis(findings=(finding(consequence=consequence(1.0, 1.2)),)))
    assert "does not fall: it goes from 1 to 1.2 N·m" in worse
    untried = diagnosis(findings=(finding(cause="shoulder", consequence=None),))
    assert verdict(untried) == "Missing and confirmed: stribeck on shoulder (felt on elbow)."
    hint = finding(doubt=doubt())
    assert verdict(diagnosis(findings=(hint,))) == "Nothing is confirmed; 1 suggested."
    mixed = diagnosis(
        findings=(finding("gear_mesh", rivals=("ripple",)), hint),
        unexplained=(Unexplained("elbow", "time", 0.1, 30.0),),
    )
    assert verdict(mixed) == (
        "On elbow one of these is missing, this motion cannot tell which: gear mesh or ripple. "
        "1 more suggested, not confirmed. On elbow 10.0% of the torque depends on time in a way "
        "that no known effect explains."
    )


def test_what_is_left_is_called_noise_only_if_it_is() -> None:
    assert "what is left is noise" in verdict(diagnosis())
    said = verdict(diagnosis(remainders=(Remainder("elbow", 0.41, 0.08),)))
    assert "more than noise: 0.41 N·m on elbow (8% of its torque)" in said


def test_a_model_that_fails_on_unseen_motion_is_not_said_to_be_done() -> None:
    noise = diagnosis().noise
    joints = diagnosis().model.joints
    for times, fails in ((4.0, False), (14.0, True)):
        missed = dict(zip(joints, noise * [1.0, times], strict=True))
        said = verdict(diagnosis(missed=missed))
        assert said.startswith("No effect of the catalogue is missing")
        assert ("14 times that noise: it has not learned enough of the arm" in said) == fails
        assert (f"N·m on {joints[1]}" in said) == fails


def test_a_load_and_a_contact_are_said_with_their_moments() -> None:
    load = verdict(diagnosis(taken_up=taken_up()))
    assert load.startswith("From 7.0 s on the arm carries a load that the model does not know")
    touch = taken_up(change=Change(7.0, 9.5, 0.1, 300.0), doubt=doubt())
    assert verdict(diagnosis(taken_up=touch)) == (
        "Something touches the arm from 7.0 s to 9.5 s: suggested, felt by shoulder, elbow."
    )


def test_the_json_of_a_run_has_all_of_it_in_plain_types() -> None:
    found = full_run()
    record = json.loads(json.dumps(run_record(found), allow_nan=False))
    assert (record["model"], record["model_name"]) == ("model.npz", model().name)
    assert (record["sources"], record["confirm"]) == (["a bag"], ["another bag"])
    assert record["confirmed_on"] == "another bag"
    assert record["verdict"] == verdict(found.diagnosis)
    assert record["null"]["threshold"] == 14.0
    assert record["noise"] == {"shoulder": 0.1, "elbow": 0.2}
    assert record["unexplained"][0]["evidence_gain"] == 40.0
    assert record["more_than_noise"] == [{"joint": "shoulder", "size": 0.4, "share": 0.06}]
    assert record["not_observable"][0]["next_motion"] == "two payloads"
    assert [one["effect"] for one in record["ranking"]] == ["stribeck", "delay"]
    assert record["preflight"] == [
        {
            "check": "saturation",
            "joint": "elbow",
            "finding": "clipped at 1.2 N·m",
            "serious": True,
            "advice": "leave these samples out",
            "values": {"limit": 1.2},
        }
    ]
    assert record["steps"] == [
        {"added": None, "error": 3.0},
        {"added": "stribeck on elbow", "error": 1.8},
    ]
    assert not {"changed", "applied", "compare"} & set(record)


def test_the_json_of_a_finding_has_its_evidence() -> None:
    first, second = run_record(full_run())["findings"]
    assert (first["effect"], first["joints"]) == ("stribeck", ["elbow"])
    assert first["caused_by"] == "elbow"
    assert (first["verdict"], first["reason"]) == ("confirmed", "")
    assert "helps in 100% of another recording" in first["why"]
    assert (first["error_before"], first["error_after"]) == (1.5, 0.9)
    assert first["blocks"][1] == {"time": 4.5, "before": 1.0, "after": 1.1}
    assert first["parameters"]["F_s"] == {"value": 1.25, "low": 1.0, "high": 1.5, "unit": "N·m"}
    assert (first["shape_words"], first["shape_units"]) == ({"v_s": "0.1"}, {"v_s": "rad/s"})
    assert (first["trial"]["gained"], first["trial"]["share"]) == (200.0, 1.0)
    assert first["signature"]["x"] == [-1.0, 0.0, 1.0]
    assert second["verdict"] == "ambiguous with counterbalance, offset"
    assert second["ambiguous_with"] == ["counterbalance", "offset"]
    assert "no more than ambiguous: it may be counterbalance or offset too" in second["why"]
    assert (second["error_before"], second["blocks"]) == (None, [])


def test_the_json_of_a_load_says_that_there_is_nothing_to_add() -> None:
    (load,) = run_record(run(diagnosis(taken_up=taken_up())))["findings"]
    assert (load["joints"], load["why"], load["p_value"]) == (list(JOINTS), "", None)
    assert load["parameters"]["t0"] == {"value": 7.0, "low": 6.9, "high": 7.2, "unit": "s"}
    assert load["holds_on_unseen"]
    assert not {"caused_by", "size", "shape_units", "trial", "signature"} & set(load)


def test_the_json_names_the_recording_of_a_fault_if_it_is_one_of_several() -> None:
    (check,) = run_record(run(diagnosis(), checks=(fault(source="a bag"),)))["preflight"]
    assert check["source"] == "a bag"


@pytest.mark.parametrize(
    ("one", "change"),
    [
        (changed("payload"), {"m": {"value": 0.5, "unit": "kg", "low": 0.4, "high": 0.6}}),
        (
            changed("coulomb", parameters={"F_c": Estimate(-1.0, unit="N·m")}),
            {"F_c": {"value": -1.0, "unit": "N·m"}},
        ),
    ],
)
def test_the_json_of_a_change_has_intervals_where_they_are_known(
    one: Changed, change: object
) -> None:
    (record,) = run_record(run(diagnosis(), changed=(one,)))["changed"]
    assert record["change"] == change
    assert (record["what"], record["joints"], record["size"]) == (one.what, ["elbow"], 1.5)


def test_the_json_of_several_rounds_tells_what_each_added() -> None:
    step = {"added": "stribeck on elbow"}
    larger = replace(model(), steps=(*model().steps, step))
    first = Round(diagnosis(findings=(finding(),)), larger)
    last = Round(diagnosis(model=larger))
    record = run_record(run(first.diagnosis, rounds=(first, last), output="better.npz"))
    assert record["applied"]["output"] == "better.npz"
    assert record["applied"]["added"] == ["stribeck on elbow"]
    assert [one["added"] for one in record["applied"]["rounds"]] == [["stribeck on elbow"], []]
    assert record["steps"][1] == {
        "added": "stribeck on elbow", "error": 1.8, "joint": "elbow", "before": 1.5, "after": 0.9,
    }  # fmt: skip
    nothing = run_record(run(diagnosis(), output="better.npz"))
    assert (nothing["applied"]["output"], nothing["steps"]) == (None, [])


def test_findings_are_read_back_from_the_json() -> None:
    found = replace(
        full_run(), rounds=(Round(diagnosis(findings=(finding(),), taken_up=taken_up())),)
    )
    load, effect = saved_findings(to_json(run_record(found)))
    assert (effect.effect, effect.joints, effect.shape) == ("stribeck", ("elbow",), {"v_s": 0.1})
    assert effect.history["evidence_gain"] == 213.0
    assert effect.history["verdict"] == "confirmed"
    over = curve_over([Over("position", 1, "elbow")], friction=True)
    rest = Unexplained("shoulder", "the position of elbow", 0.1, 60.0, over)
    text = to_json(run_record(run(diagnosis(unexplained=(rest,)))))
    (curve,) = saved_findings(text)
    assert (curve.effect, curve.joints) == ("curve_friction_position2", ("shoulder",))
    assert "60 nats" in str(curve.history["why"])
    assert json.loads(text)["unexplained"][0]["command"] == (
        "lagrangian_ff add model.npz curve --joint shoulder --over position@elbow --friction "
        "--output NEW.npz"
    )
    assert (load.once, effect.once) == (True, False)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[1]",
        "{}",
        '{"findings": 1}',
        '{"findings": [1]}',
        '{"findings": [{"effect": "drift"}]}',
    ],
)
def test_what_is_no_diagnosis_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"Expecting value|not the JSON of a diagnosis"):
        saved_findings(text)
