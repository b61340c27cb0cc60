"""The words: numbers, tables, equations, verdicts and advice."""

import json
from typing import Any

import numpy as np
import pytest
from diagnosis_examples import changed

from lagrangian_ff.cli.common.console import Console, table
from lagrangian_ff.cli.text.advice import RULES, Findings, advice, usable
from lagrangian_ff.cli.text.diagnose import say_changed
from lagrangian_ff.cli.text.effects import equations, negative_friction, parameter_table
from lagrangian_ff.cli.text.errors import error_table, verdict
from lagrangian_ff.identification.records import (
    Estimate,
    FittedEffect,
    Identified,
    JointOutliers,
    Outliers,
    Score,
)
from lagrangian_ff.identification.settings import Settings
from lagrangian_ff.record_json import to_json
from lagrangian_ff.words import grade


def effect(
    name: str, joint: str, value: float, formula: str = "c", spread: float = 0.1
) -> FittedEffect:
    """Return an effect with its number."""
    found = Estimate(value, value - spread, value + spread, "N·m")
    symbol = {"B qd": "B", "F_c tanh(qd / v0)": "F_c"}.get(formula, "c")
    shape = {"v0": "0.0200"} if "v0" in formula else {}
    return FittedEffect(name, joint, formula, {symbol: found}, shape_words=shape)


def score(**nmse: float) -> Score:
    """Return these errors on the held-out part."""
    return Score(tuple(nmse), np.ones(len(nmse)), np.array(list(nmse.values())))


def found(outside: float = 0.0, worst: str = "", **changes: Any) -> Findings:
    """Return the findings of a good model but for some changes."""
    still = changes.pop("still", ())
    usual: dict[str, Any] = {
        "model": "vrbfs+fri",
        "score": score(a=0.02, b=0.03),
        "validation": score(a=0.01),
        "samples": 500,
        "training_seconds": 30.0,
        "effects": (effect("viscous", "a", 1.0, "B qd"),),
        "settings": Settings(train=0.5),
    }
    return Findings(Identified(**{**usual, **changes}), outside, worst, still)


def test_columns_of_numbers_stand_to_the_right() -> None:
    lines = table(["joint", "x"], [["a", "1.5"], ["long", "-12"]])
    assert lines == ["  joint    x", "  a      1.5", "  long   -12"]


def test_equations_hold_their_numbers_and_signs() -> None:
    effects = [
        effect("viscous", "a", 2.5, "B qd"),
        effect("coulomb", "a", -3.0, "F_c tanh(qd / v0)"),
        effect("offset", "a", 0.25),
        effect("offset", "elbow", -1.0),
    ]
    assert equations(effects) == [
        "  a      τ = 2.50 qd - 3.00 tanh(qd / 0.0200) + 0.250",
        "  elbow  τ = -1.00",
    ]


def test_parameters_that_may_be_zero_or_drive_are_marked() -> None:
    lines = parameter_table(
        [
            effect("viscous", "a", 0.05, "B qd"),
            effect("coulomb", "b", -3.0, "F_c tanh(qd / v0)"),
            effect("offset", "b", -3.0),
        ]
    )
    assert lines[1].endswith("may be 0")
    assert lines[2].endswith("no friction")
    assert lines[3].endswith("N·m")


def test_friction_that_drives_is_told_from_a_part_that_is_negative() -> None:
    effects = [
        effect("coulomb", "a", -3.0, "F_c tanh(qd / v0)"),
        effect("viscous", "a", -0.05, "B qd"),
        effect("coulomb", "b", 3.0, "F_c tanh(qd / v0)"),
        effect("viscous", "b", -2.0, "B qd"),
        effect("viscous", "c", -0.05, "B qd"),
        effect("offset", "d", -3.0),
    ]
    assert negative_friction(effects) == (["a"], ["b"])


def test_no_effects_make_no_table() -> None:
    assert parameter_table([]) == equations([]) == []


@pytest.mark.parametrize(
    ("nmse", "word"),
    [(0.0, "very good"), (0.03, "good"), (0.1, "fair"), (0.4, "poor"), (1.2, "bad"),
     (None, "not judged: its torque did not vary")],
)  # fmt: skip
def test_an_error_in_a_word(nmse: float | None, word: str) -> None:
    assert grade(nmse) == word


def test_the_verdict_names_joints_where_they_differ() -> None:
    assert verdict(score(a=0.02, b=0.03)) == "The model is good on every joint."
    mixed = verdict(score(a=0.9, b=0.03, c=0.02))
    assert mixed == "The model is good on b, c; bad on a."
    assert any(line.endswith("bad") for line in error_table(score(a=0.9, b=0.03)))


def test_the_errors_of_a_record_are_those_that_were_written() -> None:
    errors = score(a=0.9, still=np.nan)
    again = Score.from_record(json.loads(to_json(errors.record())))
    assert error_table(again) == error_table(errors)
    assert error_table(errors)[2].split()[:3] == ["still", "1.00", "-"]
    assert "not judged" in verdict(again)


def test_of_a_robust_model_the_error_is_told_that_outliers_do_not_move() -> None:
    errors = score(a=0.9, b=0.03)
    found = {"a": JointOutliers(0.1, 1.0, 0.25), "b": JointOutliers(0.1, 1.0, 0.125)}
    header, first, second, whole = error_table(errors, Outliers(0.1, found).medians)
    assert "half below [N·m]" in header
    assert (first.split()[2], second.split()[2]) == ("0.250", "0.125")
    assert whole.split() == ["all", "joints", "1.00", "0.465"]
    assert not any("half" in line for line in error_table(errors))
    of_an_older_file = Outliers(joints={"a": JointOutliers()})
    assert error_table(errors, of_an_older_file.medians) == error_table(errors)


def test_a_model_is_recommended_only_where_it_is_good() -> None:
    assert "most of the tracking error" in usable(score(a=0.02, b=0.03))
    assert "helps" in usable(score(a=0.02, b=0.15))
    assert usable(score(a=0.02, b=0.3)) == "Do not drive b with it."
    assert usable(score(a=0.02, b=np.nan)) == "Do not drive b with it."


def test_a_change_is_told_with_its_intervals_and_rivals(capsys: pytest.CaptureFixture[str]) -> None:
    change = changed("payload", joints=("a", "b"), p_value=None, rivals=("mass of the link of b",))
    say_changed([change], "model.npz", Console())
    told = capsys.readouterr().out
    assert "m by 0.500 kg" in told
    assert "payload, 90 % intervals: m by 0.400 to 0.600 kg" in told
    assert "payload: mass of the link of b would explain as much" in told


def test_nothing_is_advised_where_all_is_well() -> None:
    assert advice(found()) == []


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (found(0.4, "position of a is 2 rad", score=score(a=0.5)), "--train 1.0"),
        (found(0.4, "position of a is 2 rad", score=score(a=0.02)), "well so far"),
        (found(score=score(a=0.5)), "did something change"),
        (found(score=score(a=0.5), training_seconds=9.0), "9.0 s of motion is little"),
        (found(score=score(a=0.1), samples=60, settings=Settings(samples=60)), "--samples 500"),
        (found(score=score(a=0.1), effects=(), model="rbf"), "--model rbf+fri"),
        (found(effects=(effect("coulomb", "a", -2.0),)), "--effort-scale a=-1"),
        (
            found(effects=(effect("coulomb", "a", 2.0), effect("viscous", "a", -2.0))),
            "the kernel has taken over",
        ),
        (found(still=("b",)), "b did not move"),
        (found(score=score(a=0.5), validation=score(a=0.4)), "No cause"),
    ],
)
def test_each_cause_has_its_advice(given: Findings, words: str) -> None:
    assert words in " ".join(advice(given))


def test_every_rule_keeps_quiet_on_a_good_result() -> None:
    assert [rule.__name__ for rule in RULES if rule(found())] == []
