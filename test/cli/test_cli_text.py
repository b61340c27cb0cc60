"""The words: numbers, tables, equations, verdicts and advice."""

from typing import Any

import pytest

from lagrangian_ff.cli.common.console import Console, table
from lagrangian_ff.cli.text.advice import RULES, Findings, advice, usable
from lagrangian_ff.cli.text.diagnose import say_changed
from lagrangian_ff.cli.text.effects import equations, negative_friction, parameter_table
from lagrangian_ff.cli.text.errors import error_table, grade, verdict


def effect(
    name: str, joint: str, value: float, formula: str = "c", spread: float = 0.1
) -> dict[str, Any]:
    """An entry of a record's list of effects."""
    parameter = {"value": value, "low": value - spread, "high": value + spread, "unit": "N·m"}
    symbol = {"B qd": "B", "F_c tanh(qd / v0)": "F_c"}.get(formula, "c")
    shape = {"v0": "0.0200"} if "v0" in formula else {}
    return {
        "effect": name, "joint": joint, "formula": formula, "parameters": {symbol: parameter},
        "shape_words": shape,
    }  # fmt: skip


def record(nmse: dict[str, float], **changes: Any) -> dict[str, Any]:
    """A record with these errors on the held-out part."""
    return {
        "model": "vrbfs+fri",
        "joints": {name: {"rmse": 1.0, "nmse": value} for name, value in nmse.items()},
        "rmse": 1.0,
        "nmse": sum(nmse.values()) / len(nmse),
        "validation": {"nmse": 0.01},
        "samples": 500,
        "training_seconds": 30.0,
        "effects": [effect("viscous", "a", 1.0, "B qd")],
        "settings": {"train": 0.5, "samples": 500},
        **changes,
    }


def test_columns_of_numbers_stand_to_the_right() -> None:
    lines = table(["joint", "x"], [["a", "1.5"], ["long", "-12"]], indent="")
    assert lines == ["joint    x", "a      1.5", "long   -12"]


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
    assert verdict(record({"a": 0.02, "b": 0.03})) == "The model is good on every joint."
    mixed = verdict(record({"a": 0.9, "b": 0.03, "c": 0.02}))
    assert mixed == "The model is good on b, c; bad on a."
    assert any(line.endswith("bad") for line in error_table(record({"a": 0.9, "b": 0.03})))


def test_of_a_robust_model_the_error_is_told_that_outliers_do_not_move() -> None:
    half = {"a": {"held_out_median": 0.25}, "b": {"held_out_median": 0.125}}
    errors = {"a": 0.9, "b": 0.03}
    header, first, second, whole = error_table(record(errors, outliers={"joints": half}))
    assert "half below [N·m]" in header
    assert (first.split()[2], second.split()[2]) == ("0.250", "0.125")
    assert whole.split() == ["all", "joints", "1.00", "0.465"]
    assert not any("half" in line for line in error_table(record(errors)))
    of_an_older_file = record(errors, outliers={"joints": {"a": {}, "b": {}}})
    assert error_table(of_an_older_file) == error_table(record(errors))


def test_a_model_is_recommended_only_where_it_is_good() -> None:
    assert "most of the tracking error" in usable(record({"a": 0.02, "b": 0.03}))
    assert "helps" in usable(record({"a": 0.02, "b": 0.15}))
    assert usable(record({"a": 0.02, "b": 0.3})) == "Do not drive b with it."


def test_a_change_is_told_with_its_intervals_and_rivals(capsys: pytest.CaptureFixture[str]) -> None:
    mass = {"value": 0.5, "unit": "kg", "low": 0.4, "high": 0.6}
    change = {
        "what": "payload", "joints": ["a", "b"], "evidence_gain": 90.0, "p_value": None,
        "change": {"m": mass}, "size": 1.5, "rivals": ["mass of the link of b"],
    }  # fmt: skip
    say_changed([change], "model.npz", Console())
    told = capsys.readouterr().out
    assert "m by 0.500 kg" in told
    assert "payload, 90 % intervals: m by 0.400 to 0.600 kg" in told
    assert "payload: mass of the link of b would explain as much" in told


def test_nothing_is_advised_where_all_is_well() -> None:
    assert advice(Findings(record({"a": 0.02, "b": 0.03}))) == []


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (Findings(record({"a": 0.5}), 0.4, "position of a is 2 rad"), "--train 1.0"),
        (Findings(record({"a": 0.02}), 0.4, "position of a is 2 rad"), "well so far"),
        (Findings(record({"a": 0.5})), "did something change"),
        (Findings(record({"a": 0.5}, training_seconds=9.0)), "9.0 s of motion is little"),
        (Findings(record({"a": 0.1}, samples=60, settings={"train": 1.0, "samples": 60})),
         "--samples 500"),
        (Findings(record({"a": 0.1}, effects=[], model="rbf")), "--model rbf+fri"),
        (Findings(record({"a": 0.02}, effects=[effect("coulomb", "a", -2.0)])),
         "--effort-scale a=-1"),
        (Findings(record({"a": 0.02}, effects=[
            effect("coulomb", "a", 2.0), effect("viscous", "a", -2.0)])),
         "the kernel has taken over"),
        (Findings(record({"a": 0.02}), still=("b",)), "b did not move"),
        (Findings(record({"a": 0.5}, validation={"nmse": 0.4})), "No cause"),
    ],
)  # fmt: skip
def test_each_cause_has_its_advice(found: Findings, words: str) -> None:
    assert words in " ".join(advice(found))


def test_every_rule_keeps_quiet_on_a_good_result() -> None:
    found = Findings(record({"a": 0.02, "b": 0.03}))
    assert [rule.__name__ for rule in RULES if rule(found)] == []
