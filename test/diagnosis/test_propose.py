"""Formulas proposed for what no effect of the catalogue explains."""

import json
from pathlib import Path

import numpy as np
import pytest
import two_rods
from hypothesis import given
from hypothesis import strategies as st
from whitened_examples import few_torques, inputs

from lagrangian_ff.diagnosis.proposing import Proposals, proposals_record, propose
from lagrangian_ff.diagnosis.proposing.grammar import forms
from lagrangian_ff.effects import EFFECTS, Over, curve_over
from lagrangian_ff.effects.user import check, load_effects
from lagrangian_ff.errors import EffectError, ModelError
from lagrangian_ff.identification import Model, Settings, extend, identify
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.record_json import to_json

FEW = Settings(train=1.0, samples=120, evaluations=20)
SORE = "formula_friction_bump_position"


_small = few_torques(800)


@pytest.fixture(scope="module")
def model() -> Model:
    return identify(two_rods.motion(1, hidden=two_rods.sore_spot), FEW).model


@pytest.fixture(scope="module")
def found(model: Model) -> Proposals:
    first, second = (two_rods.motion(seed, hidden=two_rods.sore_spot) for seed in (1, 2))
    over = ("position", "velocity")
    return propose(model, first, second, "shoulder", over)


def test_the_true_form_is_proposed_with_its_numbers(found: Proposals) -> None:
    names = [one.name for one in found.proposals]
    assert SORE in names[:2]
    one = found.proposals[names.index(SORE)]
    assert one.finding.verdict.value in ("confirmed", "ambiguous")
    assert one.finding.log_bayes_factor > found.threshold
    before, after = one.finding.errors
    assert before is not None
    assert after is not None
    assert after < 0.7 * before
    assert "dry friction that differs near position" in one.words
    assert one.finding.parameters["A"].unit == "N·m"
    assert one.finding.shape == pytest.approx({"c": 0.2, "w": 0.1}, abs=0.03)
    assert found.tried > 200


def test_proposals_are_a_file_of_effects(found: Proposals, tmp_path: Path, model: Model) -> None:
    file = tmp_path / "mine.json"
    file.write_text(to_json(found.record()), encoding="utf-8")
    before = dict(EFFECTS)
    try:
        loaded = load_effects(file)
        assert [one.name for one in loaded] == [one.name for one in found.proposals]
        one, same = found.proposals[0].finding, loaded[0]
        assert [(p.name, p.unit) for p in same.parameters] == [
            (p.name, p.unit) for p in one.effect.parameters
        ]
        assert [s.grid() for s in same.shapes] == [s.grid() for s in one.effect.shapes]
        x = inputs(two_rods.motion(3, 5.0))
        np.testing.assert_allclose(
            Term(same, 0, one.shape).columns(x), Term(one.effect, 0, one.shape).columns(x)
        )
    finally:
        for name in set(EFFECTS) - set(before):
            del EFFECTS[name]
    record = json.loads(to_json(proposals_record(found)))
    assert record["proposals"][0]["verdict"] == found.proposals[0].finding.said
    assert [one["name"] for one in record["effects"]] == [one.name for one in found.proposals]


def test_a_curve_of_the_model_is_what_formulas_are_to_replace(model: Model) -> None:
    motions = [two_rods.motion(seed, hidden=two_rods.sore_spot) for seed in (1, 2)]
    curved = extend(model, curve_over([Over("position")], friction=True), "shoulder").model
    found = propose(curved, motions[0], motions[1], over=("position",))
    assert found.joint == "shoulder"
    assert SORE in [one.name for one in found.proposals[:2]]
    error = found.proposals[0].finding.errors[1]
    assert found.curve_error is not None
    assert error is not None
    assert 0.5 < error / found.curve_error < 1.5


def test_nothing_is_confirmed_where_nothing_is_missing() -> None:
    first, second = (two_rods.motion(seed) for seed in (5, 6))
    found = propose(identify(first, FEW).model, first, second, "elbow", ("velocity",))
    assert all(one.finding.verdict.value == "suggested" for one in found.proposals)


def test_what_cannot_be_asked_is_said(model: Model) -> None:
    motion = two_rods.motion(1, hidden=two_rods.sore_spot)
    with pytest.raises(ModelError, match="no joint 'knee'"):
        propose(model, motion, joint="knee")
    with pytest.raises(EffectError, match="expected one or two of position"):
        propose(model, motion, joint="elbow", over=("speed",))


@given(st.integers(0, 10_000))
def test_every_formula_of_the_grammar_is_sound_and_has_dimensions(number: int) -> None:
    every = forms(inputs(two_rods.motion(1, 5.0)), 0, two_rods.JOINTS)
    assert len({one.effect.name for one in every}) == len(every)
    one = every[number % len(every)]
    check(one.effect)
    assert all("N·m" in p.unit or p.unit == "1" for p in one.effect.parameters)
    assert all(shape.unit != "SI" for shape in one.effect.shapes)
    shape = {each.name: each.start for each in one.effect.shapes}
    assert "{" not in one.words(shape) + one.effect.meaning


def test_formulas_are_of_the_coordinates_that_are_allowed() -> None:
    x = inputs(two_rods.motion(1, 5.0))
    some = forms(x, 0, two_rods.JOINTS, [Over("velocity"), Over("position", 1, "elbow")])
    kinds = {(one.kind, one.joint) for form in some for one in form.coordinate.of}
    assert kinds == {("velocity", None), ("position", 1)}
