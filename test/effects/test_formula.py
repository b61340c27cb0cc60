"""Effects written as formulas: what they compute, and what is refused without being run."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.effects.formula import formula_effect
from lagrangian_ff.effects.user import check, load_effects, trial_motion
from lagrangian_ff.errors import EffectError


def test_a_formula_is_the_effect_that_python_defines() -> None:
    x = trial_motion()
    drag = formula_effect("mine", "C*qd*abs(qd)", {})
    np.testing.assert_allclose(
        drag.columns(x, 1, {}), EFFECTS["quadratic_drag"].columns(x, 1, {}), atol=1e-12
    )
    check(drag)


def test_parameters_are_factors_and_what_has_a_range_is_searched() -> None:
    x = trial_motion()
    bump = formula_effect("bump", "A*exp(-(q/w)^2) - 2*B*sin(q)/pi + A*qd", {"w": (0.1, 1.0)})
    assert [one.name for one in bump.parameters] == ["A", "B"]
    assert [one.name for one in bump.shapes] == ["w"]
    columns = bump.columns(x, 0, {"w": 0.5})
    q, qd = x.q[:, 0], x.qd[:, 0]
    np.testing.assert_allclose(columns[:, 0], np.exp(-((q / 0.5) ** 2)) + qd, atol=1e-12)
    np.testing.assert_allclose(columns[:, 1], -2.0 * np.sin(q) / np.pi, atol=1e-12)
    check(bump)


@pytest.mark.parametrize(
    ("formula", "over"),
    [
        ("A*sin(q)", "position"),
        ("A*qd*abs(qd)", "velocity"),
        ("sign(qd)*A*exp(-(q/w)^2)", "position"),
        ("sign(qd)*(A*load^2)", "load"),
        ("A*qdd*abs(qdd)", "acceleration"),
        ("sign(qd)*A*exp(-since/w)", "since_reversal"),
        ("A*sin(q_2)", "position"),
    ],
)
def test_it_is_drawn_over_what_its_function_is_of(formula: str, over: str) -> None:
    shapes = {"w": (0.1, 1.0)} if "w" in formula else {}
    assert formula_effect("mine", formula, shapes).coordinate == over


def test_a_place_may_be_negative_and_is_searched_evenly() -> None:
    x = trial_motion()
    for given_range in ((-0.5, 1.0, 16), (0.1, 1.6, 16, "even"), (0.0, 1.5, 16, "even")):
        bump = formula_effect("bump", "A*exp(-((q-c)/0.2)^2)", {"c": given_range})
        (place,) = bump.shapes
        grid = place.grid()
        assert (min(grid), max(grid)) == pytest.approx((place.low, place.high))
        gaps = np.diff(grid)
        assert gaps.max() < 2.0 * gaps.min()
        for value in grid:
            assert place.value(place.logarithm(value)) == pytest.approx(value, abs=1e-12)
        shape = {"c": grid[3]}
        expected = np.exp(-(((x.q[:, 0] - grid[3]) / 0.2) ** 2))
        np.testing.assert_allclose(bump.columns(x, 0, shape)[:, 0], expected, atol=1e-12)
        check(bump)
    (width,) = formula_effect("wave", "A*sin(w*q)", {"w": (0.1, 1.0, 5)}).shapes
    assert not width.even
    np.testing.assert_allclose(width.grid(), np.geomspace(0.1, 1.0, 5))


def test_formulas_read_other_joints_and_the_time_since_a_reversal() -> None:
    x = trial_motion()
    text = "A*cos(q-q_3) + B*qd_2 + C*sign(qd)*exp(-since/T)"
    both = formula_effect("both", text, {"T": (0.1, 2.0)})
    columns = both.columns(x, 0, {"T": 0.5})
    np.testing.assert_allclose(columns[:, 0], np.cos(x.q[:, 0] - x.q[:, 2]), atol=1e-12)
    np.testing.assert_allclose(columns[:, 1], x.qd[:, 1], atol=1e-12)
    decay = x.sign(0) * np.exp(-x.since_reversal(0) / 0.5)
    np.testing.assert_allclose(columns[:, 2], decay, atol=1e-12)
    assert both.remembers
    assert both.candidates(x, 0)
    assert not both.candidates(x, 2)  # which it reads as another one
    check(both)
    far = formula_effect("far", "A*q_9", {})
    check(far)
    assert not far.candidates(x, 0)
    with pytest.raises(EffectError, match="joint 9; there are 3"):
        far.columns(x, 0, {})


def test_what_no_velocity_is_in_is_no_friction() -> None:
    parts = {"A*sign(qd)*q": "friction", "A*exp(-since)": "friction", "A*qdd*abs(qdd)": "inertia",
             "A*sin(q)": "gravity", "A*load^2": "gravity"}  # fmt: skip
    assert {text: formula_effect("mine", text, {}).part for text in parts} == parts


def test_a_sign_is_as_wide_as_that_of_the_model() -> None:
    x = replace(trial_motion(), sign_speed=np.full(3, 0.3))
    found = formula_effect("dry", "A*sign(qd)", {}).columns(x, 0, {})[:, 0]
    np.testing.assert_array_equal(found, x.sign(0))


def test_units_and_the_number_of_values_come_from_the_file(tmp_path: Path) -> None:
    file = tmp_path / "mine.json"
    one = {
        "name": "my_wave", "formula": "A*cos(n*q)", "shapes": {"n": [1.0, 20.0, 33]},
        "units": {"A": "N·m", "n": "1"},
    }  # fmt: skip
    file.write_text(json.dumps({"effects": [one]}))
    try:
        (effect,) = load_effects(file)
        assert (effect.parameters[0].unit, effect.shapes[0].unit) == ("N·m", "1")
        assert len(effect.candidates(trial_motion(), 0)) == 33
    finally:
        EFFECTS.pop("my_wave", None)


@pytest.mark.parametrize(
    ("formula", "shapes", "words"),
    [
        ("", {}, "expected a formula"),
        ("A*qd)", {}, "is no formula"),
        ("A*qd if 1else 0", {}, "is no formula"),
        ("qd", {}, "no parameter"),
        ("A*qd + sin(q)", {}, "no parameter as a factor"),
        ("A*sin(B*q)", {}, "not linear in B"),
        ("A*B*q", {}, "not linear in A"),
        ("qd^A", {}, "not linear in A"),
        ("A*qd", {"w": (0.1, 1.0)}, "not in the formula"),
        ("A*sin(w*q)", {"w": (1.0, 0.1)}, "0 < low < high"),
        ("A*exp(-(q/w)^2)", {"w": (0.0, 1.0)}, "0 < low < high"),
        ("A*cos(q-c)", {"c": (0.1, 1.0, 6, "evenly")}, "expected 'even'"),
        ("__import__('os').system('true')", {}, "holds"),
        ("A*q.real", {}, "holds"),
        ("A*[x for x in q]", {}, "holds"),
        ("A*(lambda: 1)()", {}, "holds"),
        ("A*open(q)", {}, "holds"),
        ("A*9**9**9**9", {}, "finite"),
        ("A*1e300", {}, "holds"),
    ],
)
def test_what_is_no_such_formula_is_said(
    formula: str, shapes: dict[str, tuple[float, float]], words: str
) -> None:
    with pytest.raises(EffectError, match=words):
        check(formula_effect("mine", formula, shapes))


@given(st.text("AqBd()+-*/^.1 sinexp", max_size=40))
def test_any_text_is_a_formula_or_refused_in_words(text: str) -> None:
    try:
        effect = formula_effect("mine", text, {})
    except EffectError:
        return
    assert effect.columns(trial_motion(), 0, {}).shape == (1000, len(effect.parameters))


def test_a_file_of_formulas_takes_part_like_one_of_python(tmp_path: Path) -> None:
    file = tmp_path / "mine.json"
    one = {"name": "my_bump", "formula": "A*exp(-(q/w)^2)", "shapes": {"w": [0.1, 1.0]}}
    file.write_text(json.dumps({"effects": [one]}))
    try:
        (effect,) = load_effects(file)
        assert EFFECTS["my_bump"] is effect
    finally:
        EFFECTS.pop("my_bump", None)
    for wrong in ("[]", "{", '{"effects": [{"formula": 3}]}', '{"effects": 5}'):
        file.write_text(wrong)
        with pytest.raises(EffectError):
            load_effects(file)
