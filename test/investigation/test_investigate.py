"""The loop that closes itself, on an arm whose torques can be written down."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from pendulum_rig import START, PendulumRig, limits, plan

from lagrangian_ff.diagnosis.excite import Between, Everything, For, Suspect
from lagrangian_ff.diagnosis.excite.assumed import SIZE
from lagrangian_ff.diagnosis.excite.keeping import jerk_of
from lagrangian_ff.effects.formula import formula_effect
from lagrangian_ff.effects.user import load_effects
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model
from lagrangian_ff.investigation import (
    Asked,
    Ended,
    Investigation,
    Proposal,
    StoppedError,
    investigate,
)
from lagrangian_ff.investigation.motions import for_design, size_of
from lagrangian_ff.investigation.story import answered
from lagrangian_ff.record_json import to_json
from lagrangian_ff.report import investigation_page
from lagrangian_ff.words import sentence

DRAG = 0.9  # N·m s²/rad²
FAINT = 0.08
"""N·m s²/rad²: one motion alone does not show that adding it helps."""


@cache
def found(drag: float) -> tuple[PendulumRig, Investigation, list[Proposal]]:
    """Return an arm with a drag, its story, and what was asked for."""
    rig, proposals = PendulumRig(drag), list[Proposal]()

    def permit(proposal: Proposal) -> bool:
        proposals.append(proposal)
        return True

    return rig, investigate(rig, plan(36.0), permit), proposals


@pytest.mark.parametrize("hidden", [DRAG, FAINT])
def test_it_adds_the_drag_that_is_hidden(hidden: float) -> None:
    _, story, _ = found(hidden)
    last = story.turns[-1]
    assert [one.name for one in story.confirmed] == ["quadratic_drag on elbow"]
    (term,) = [one for one in last.confirmed if one.joint == "elbow"]
    (drag,) = term.parameters.values()
    assert drag.low < hidden < drag.high
    assert story.model is last.model


def test_the_error_falls() -> None:
    _, story, _ = found(DRAG)
    assert story.turns[-1].errors["elbow"] < 0.5 * story.before["elbow"]


def test_it_sets_a_lag_of_all_torques_right() -> None:
    late = 0.008
    story = investigate(PendulumRig(DRAG, late=late), plan(24.0), lambda proposal: True)
    lag = next(turn.diagnosis.lag for turn in story.turns if turn.diagnosis.lag is not None)
    assert abs(lag.delay - late) < 3.0 * lag.deviation
    conditioning = story.turns[-1].model.identified.conditioning
    assert conditioning is not None
    assert conditioning.effort_delay == pytest.approx(lag.delay)
    assert [one.name for one in story.confirmed] == ["quadratic_drag on elbow"]


def test_it_asks_for_what_one_motion_does_not_decide() -> None:
    _, story, _ = found(FAINT)
    last = story.turns[-1]
    assert isinstance(last.question, For)
    assert last.question.suspect.joint == "elbow"
    assert last.expected is not None
    assert last.gained is not None
    assert last.gained > 10.0


def test_it_ends_where_nothing_is_left_within_its_budget_and_leaves_no_limit() -> None:
    rig, story, _ = found(FAINT)
    assert story.ended is Ended.NOTHING_LEFT
    assert story.seconds == pytest.approx(rig.seconds)
    assert sum(turn.seconds for turn in story.turns) == pytest.approx(story.seconds)
    assert 24.0 < story.seconds <= 36.0
    assert rig.left(limits()) == 0
    for one in rig.moved:
        np.testing.assert_allclose([one.q[0], one.q[-1]], [START, START])
        np.testing.assert_allclose([one.qd[0], one.qd[-1]], 0.0, atol=1e-9)


def test_it_asks_before_the_first_motion_and_before_the_larger_range() -> None:
    rig, _, (first, second) = found(DRAG)
    assert (first.share, second.share) == (0.5, 1.0)
    np.testing.assert_allclose(first.start, START)
    assert (first.limits.q_high < second.limits.q_high).all()
    assert (first.seconds, second.seconds) == (36.0, pytest.approx(36.0 - rig.moved[0].time[-1]))
    assert (rig.moved[0].q <= first.limits.q_high).all()
    assert "elbow -0.80 to 0.55 rad, up to 3 rad/s" in first.words


def test_it_tells_each_question_before_the_motion_and_its_answer_after_it() -> None:
    rig, told = PendulumRig(), list[Asked]()
    story = investigate(rig, plan(12.0), lambda proposal: True, listen=told.append)
    before, after = told
    assert (before.words, before.answer) == ("What does the arm do?", "")
    assert before.seconds == float(rig.moved[0].time[-1])
    assert after == replace(before, answer=story.turns[0].answer)
    assert story.ended is Ended.BUDGET


def test_an_answer_begins_with_what_became_of_the_effect_that_was_asked_for() -> None:
    _, story, _ = found(DRAG)
    last = story.turns[-1]
    (one,) = last.confirmed
    it, other = Suspect(one.effect.name, one.joint), Suspect("ripple", "elbow")
    mine = Suspect("mine", "elbow", formula=formula_effect("mine", "A*q", {}))
    for question, words in (
        (None, "Missing and confirmed: "),
        (For(it), "Yes. Missing and confirmed: "),
        (For(other), "It does not show. Missing"),
        (Between(it, other), f"It is quadratic drag on {one.joint}. Missing"),
        (Between(other, other), "Neither shows. Missing"),
        (Between(mine, mine), "It is open still. Missing"),
        (Everything(), f"New: quadratic drag on {one.joint}. Missing"),
    ):
        assert answered(question, last.diagnosis).startswith(words)
    again = answered(Everything(), last.diagnosis, known=[one.name])
    assert again.startswith("Nothing new is confirmed. Missing")
    alike = replace(last.diagnosis, findings=(replace(one, rivals=("ripple",)),))
    of_rival = answered(For(other), alike)
    assert of_rival.startswith(f"It may be that, or quadratic drag on {one.joint}. ")


def test_a_question_that_no_motion_settles_is_left_open_and_told() -> None:
    """Here after the first motions everything touches, so that no design is clear."""
    rig = PendulumRig(FAINT)

    def clear(path: np.ndarray) -> str:
        return "the wall" if len(rig.moved) > 1 else ""

    story = investigate(rig, plan(36.0, clear=clear), lambda proposal: True)
    (left,) = story.passed_over
    assert (left.question, left.expected) == (For(Suspect("quadratic_drag", "elbow")), None)
    assert "quadratic drag on elbow? No motion within the limits shows it." in left.said
    assert story.record()["passed_over"][0]["question"].startswith("Is there quadratic drag")


def test_a_motion_is_designed_for_an_effect_as_large_as_it_was_found() -> None:
    _, story, _ = found(DRAG)
    last = story.turns[-1]
    (one,) = [one for one in last.diagnosis.findings if one.joint == "elbow"]
    spread = float(np.std(last.model.data.tau[:, 1]))
    question = For(Suspect(one.effect.name, "elbow"))
    size = size_of(last.diagnosis.findings, question, last.model)
    assert size == pytest.approx(one.size / spread)
    other = For(Suspect("ripple", "elbow"))
    assert size_of(last.diagnosis.findings, other, last.model) == SIZE != size


def test_a_motion_is_designed_with_one_of_two_that_look_alike() -> None:
    """Whichever is there, without it the model takes it for noise; but not if it is in question."""
    _, story, _ = found(DRAG)
    last = story.turns[-1].diagnosis
    (one,) = [one for one in last.findings if one.joint == "elbow"]
    alike = replace(last, findings=(replace(one, rivals=("ripple",)),))
    drag, ripple, other = (
        Suspect(name, "elbow") for name in (one.effect.name, "ripple", "position_friction")
    )
    for question, there in (
        (Everything(), True),
        (For(other), True),
        (For(ripple), False),
        (Between(drag, ripple), False),
    ):
        terms = for_design(alike, question).basis.terms
        assert any(term.effect.name == drag.effect for term in terms) == there


def test_a_stop_while_the_rest_is_looked_at_keeps_the_story() -> None:
    def stop(share: float, label: str) -> None:
        if label == "looking at what no effect fits":
            raise StoppedError("enough")

    story = investigate(PendulumRig(), plan(12.0), lambda proposal: True, stop)
    assert (story.ended, story.words, len(story.turns)) == (Ended.STOPPED, "enough", 1)


def test_nothing_moves_without_permission() -> None:
    rig = PendulumRig(DRAG)
    story = investigate(rig, plan(36.0), lambda proposal: False)
    assert story.ended is Ended.REFUSED
    assert (story.turns, story.model, rig.moved) == ((), None, [])


def test_without_permission_for_more_it_stays_in_the_smaller_range() -> None:
    rig = PendulumRig()
    small = plan(12.0)
    story = investigate(rig, small, lambda proposal: proposal.share < 1.0)
    assert len(rig.moved) == len(story.turns) == 1
    assert rig.left(limits().around(START, 0.5)) == 0
    assert not story.confirmed
    assert story.ended is Ended.BUDGET


def test_a_stop_keeps_what_is_known() -> None:
    rig = PendulumRig(FAINT, last=3)
    story = investigate(rig, plan(36.0), lambda proposal: True)
    assert (story.ended, story.words) == (Ended.STOPPED, "somebody stopped it")
    assert len(rig.moved) == 2
    (turn,) = story.turns
    assert turn.question is None
    assert [one.effect.name for one in turn.diagnosis.findings] == ["quadratic_drag"]
    assert story.model is not None
    assert story.record()["words"] == "somebody stopped it"


def test_a_stop_before_anything_is_known_is_told_too() -> None:
    story = investigate(PendulumRig(last=1), plan(36.0), lambda proposal: True)
    assert (story.ended, story.turns, story.before) == (Ended.STOPPED, (), {})


def test_every_motion_keeps_the_jerk_and_the_torque_that_were_permitted() -> None:
    jerk, torque = np.array([20.0, 30.0]), np.array([60.0, 30.0])
    allowed = replace(limits(), jerk_max=jerk, tau_max=torque)
    rig = PendulumRig(FAINT)
    story = investigate(rig, replace(plan(33.0), limits=allowed), lambda proposal: True)
    assert len(story.turns) > 1
    for one in rig.moved:
        assert np.all(np.abs(jerk_of(one)) <= jerk * (1.0 + 1e-6))
    for turn in story.turns[1:]:
        assert np.all(np.abs(turn.model.predict(*turn.motion[1:])) <= torque)


def test_a_first_motion_takes_less_of_the_range_until_it_is_clear() -> None:
    rig = PendulumRig()
    high = START[0] + 0.25

    def clear(path: np.ndarray) -> str:
        return "the wall" if path[:, 0].max() > high else ""

    investigate(rig, plan(12.0, clear=clear), lambda proposal: True)
    assert rig.moved[0].q[:, 0].max() <= high
    with pytest.raises(ModelError, match="the wall"):
        investigate(PendulumRig(), plan(12.0, clear=lambda path: "the wall"), lambda p: True)


def test_a_question_without_a_motion_gives_way_to_the_next() -> None:
    """Here from the second motion on everything touches, so that no design is clear."""
    rig = PendulumRig(DRAG)

    def clear(path: np.ndarray) -> str:
        return "the wall" if rig.moved else ""

    story = investigate(rig, plan(40.0, clear=clear, reaches=(1.0,)), lambda proposal: True)
    assert story.ended is Ended.NOTHING_LEFT
    assert len(story.turns) == len(rig.moved) == 1


def test_a_formula_that_unseen_motion_confirms_is_added(tmp_path: Path) -> None:
    story = investigate(PendulumRig(rough=0.3), plan(24.0), lambda proposal: True)
    assert [one.name for one in story.confirmed] == ["formula_friction_wave_position on elbow"]
    assert not story.curves
    assert story.turns[-1].errors["elbow"] < 0.2 * story.before["elbow"]
    (term,) = [one for one in story.confirmed[0].parameters.items() if one[0] == "B"]
    assert term[1].low < 0.3 < term[1].high
    assert story.confirmed[0].shape["n"] == pytest.approx(5.3, rel=0.02)
    assert story.model is not None
    story.model.save(tmp_path / "model.npz")  # needs no other file
    assert Model.load(tmp_path / "model.npz").name == story.model.name
    page = investigation_page(tmp_path / "story.html", story).read_text()
    for words in ("Found formula friction wave position on elbow", "What nobody listed"):
        assert words in page
    assert "wave_position" in story.record()["unlisted"]["proposals"][0]["proposals"][0]["name"]


@pytest.mark.usefixtures("catalogue_kept")
def test_what_no_formula_surely_fits_becomes_a_curve(tmp_path: Path) -> None:
    story = investigate(PendulumRig(drag=0.2, rough=0.3), plan(24.0), lambda proposal: True)
    assert story.unlisted is not None
    assert [one.joint for one in story.curves] == ["elbow"]
    assert story.errors["elbow"] < 0.5 * story.turns[-1].errors["elbow"]
    assert story.model is story.unlisted.model
    assert story.model.name.endswith("curve_friction_position@elbow")
    formulas = [one["formula"] for one in story.unlisted.effects]
    assert formulas[0] == "sign(qd)*(A*cos(n*q)+B*sin(n*q))"
    file = tmp_path / "mine.json"
    file.write_text(to_json({"effects": story.unlisted.effects}))
    assert len(load_effects(file)) == len(formulas)
    page = investigation_page(tmp_path / "story.html", story).read_text()
    assert "What nobody listed" in page
    assert "A torque of elbow that nobody listed, held as a curve" in page
    first = story.unlisted.proposals[0].proposals[0]
    residual = first.finding.partial_residual
    assert residual is not None
    assert residual.coordinate == "position"
    np.testing.assert_allclose(residual.effect, residual.residual, atol=0.1)
    assert f"{sentence(first.words)}</p>" in page
    assert story.record()["unlisted"]["rmse"] == pytest.approx(story.total)


def test_an_arm_that_stands_still_when_it_is_sent_loses_nothing() -> None:
    story = investigate(PendulumRig(FAINT, stuck=3), plan(36.0), lambda proposal: True)
    assert story.ended is Ended.STOPPED
    assert "no joint moves" in story.words
    (turn,) = story.turns
    assert [one.effect.name for one in turn.diagnosis.findings] == ["quadratic_drag"]
    assert story.model is not None
