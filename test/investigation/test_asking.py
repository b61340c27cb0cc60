"""The next question: what is open, what is usual first, and never without end."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_examples import JOINTS, diagnosis, doubt, finding

from lagrangian_ff.diagnosis.confidence import Doubt, Reason
from lagrangian_ff.diagnosis.excite import (
    Between,
    Design,
    Everything,
    Expected,
    For,
    Parameters,
    Question,
    Reference,
    Suspect,
)
from lagrangian_ff.diagnosis.results import Diagnosis, Finding, Ranked, Unexplained
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.effects.formula import formula_effect
from lagrangian_ff.investigation import next_question
from lagrangian_ff.investigation.asking import (
    HOPE,
    MOST_EVERYTHING,
    TWICE,
    about_formulas,
    denies,
    promising,
    unsettled,
)

STRIBECK = For(Suspect("stribeck", "elbow"))


def asked(
    found: Diagnosis, before: tuple[Question, ...] = (), *, unseen: bool = False
) -> Question | None:
    return next_question(found, lambda: unseen, before)


def made(question: Question, nats: float, **expected: float) -> Design:
    """Return a design with the nats of some effects on the elbow."""
    still = np.zeros((2, len(JOINTS)))
    every = tuple(
        Expected(name, "elbow", 0.03, 1.0, one, 100.0, one) for name, one in expected.items()
    )
    reference = Reference(np.array([0.0, 1.0]), still, still, still)
    return Design(question, JOINTS, reference, nats, every, {}, "a sweep")


def test_a_confirmed_effect_leaves_nothing_open() -> None:
    assert asked(diagnosis(findings=(finding(),))) is None
    assert asked(diagnosis()) is None


def test_two_formulas_are_asked_about_twice_a_joint_whatever_their_shapes() -> None:
    def pair(joint: str, middle: float) -> tuple[Between, Finding]:
        both = (
            Suspect(name, joint, {"c": middle}, formula_effect(name, formula, {"c": (-1.0, 1.0)}))
            for name, formula in (("near", "A*tanh(q-c)"), ("loaded", "A*load*tanh(q-c)"))
        )
        return Between(*both), finding(joint=joint)

    first, again, other = pair("elbow", 0.1), pair("elbow", 0.2), pair("shoulder", 0.1)
    assert about_formulas([], []) is None
    assert about_formulas([first, other], []) == first[0]
    assert about_formulas([again, other], [first[0], STRIBECK]) == again[0]
    assert about_formulas([again, other], [first[0], first[0]]) == other[0]
    assert about_formulas([again], [first[0], again[0]]) is None


def test_a_suggested_effect_is_asked_for() -> None:
    found = diagnosis(findings=(finding(doubt=doubt()),))
    assert asked(found) == STRIBECK


def test_what_is_there_but_lowers_no_error_is_asked_for_last() -> None:
    there = finding(doubt=Doubt(Reason.NO_HELP, "it does not lower the error"))
    lead = Ranked("ripple", "shoulder", 15.0, named=True, stands_out=False)
    both = diagnosis(findings=(there,), waiting=(lead,))
    first = For(Suspect("ripple", "shoulder"))
    assert asked(both) == first
    assert asked(both, (first,) * TWICE) == STRIBECK
    assert asked(both, (first, STRIBECK) * TWICE) is None


def test_what_happens_once_is_no_question() -> None:
    contact = next(one for one in EFFECTS.values() if one.kind == "event")
    found = diagnosis(findings=(finding(effect="stribeck", doubt=doubt()),))
    once = finding("spring", doubt=doubt())
    object.__setattr__(once, "effect", contact)
    assert asked(diagnosis(findings=(once,))) is None
    assert asked(diagnosis(findings=(once, *found.findings))) == STRIBECK


def test_rivals_are_told_apart_the_usual_one_of_the_gear_first() -> None:
    rivals = ("ripple", "backlash", "hysteresis")
    found = diagnosis(findings=(finding("spring", rivals=rivals),))
    usual: dict[str, list[str]] = {}
    for gear in ("harmonic", "planetary"):
        before: list[Between] = []
        gears = {"elbow": gear}
        while (question := next_question(found, lambda: False, before, gears)) is not None:
            assert isinstance(question, Between)
            assert question.first == Suspect("spring", "elbow")
            before.append(question)
        usual[gear] = [one.second.effect for one in before[::TWICE]]
        assert sorted(usual[gear]) == sorted(rivals)
        assert len(before) == TWICE * len(rivals)
    assert usual["harmonic"][0] != "backlash" == usual["planetary"][0]


def test_what_no_motion_shows_is_no_question() -> None:
    """A touch happens or does not: no motion tells an effect from it."""
    both = diagnosis(findings=(finding("spring", rivals=("contact", "ripple")),))
    between = Between(Suspect("spring", "elbow"), Suspect("ripple", "elbow"))
    assert asked(both) == between
    assert asked(both, (between,) * TWICE) is None
    alone = diagnosis(findings=(finding("spring", rivals=("contact",), doubt=doubt()),))
    assert asked(alone) == For(Suspect("spring", "elbow"))
    touch = Ranked("contact", "elbow", 50.0, named=True, stands_out=True)
    assert asked(diagnosis(waiting=(touch,))) is None


def test_one_question_is_asked_twice_at_most() -> None:
    found = diagnosis(findings=(finding(doubt=doubt()),))
    assert asked(found, (STRIBECK,)) == STRIBECK
    assert asked(found, (STRIBECK,) * TWICE) is None


def test_two_rivals_are_one_question_in_either_order() -> None:
    one, other = Suspect("spring", "elbow"), Suspect("ripple", "elbow")
    found = diagnosis(findings=(finding("spring", rivals=("ripple",)),))
    assert asked(found, (Between(other, one),)) == Between(one, other)
    assert asked(found, (Between(other, one), Between(one, other))) is None


def test_a_model_that_fails_on_unseen_motion_is_taught_the_arm_last() -> None:
    fails = diagnosis(missed={"shoulder": 0.02, "elbow": 1.5})
    assert fails.failing == {"elbow": 1.5}
    assert asked(fails, unseen=True) == Everything()
    assert asked(fails) == Parameters()
    assert asked(fails, (Parameters(),) * TWICE) is None
    assert promising(fails, made(Parameters(), 0.0), {})
    knows = diagnosis(missed={"shoulder": 0.02, "elbow": 0.3})
    assert asked(knows) is None
    assert not denies(Parameters(), fails, knows)
    assert denies(Parameters(), fails, fails)


def test_what_nobody_explains_is_why_it_fails_and_more_motion_does_not_help() -> None:
    rest = Unexplained("shoulder", "position", 0.19, 40.0)
    assert asked(diagnosis(missed={"elbow": 1.5}, unexplained=(rest,))) is None


def test_what_is_no_effect_of_the_catalogue_is_not_asked_for() -> None:
    mine = formula_effect("my_wave", "A*cos(3*q)", {})
    found = finding(doubt=doubt())
    assert asked(diagnosis(findings=(replace(found, effect=mine),))) is None


def test_a_motion_that_shows_no_more_of_an_effect_says_no() -> None:
    lead = Ranked("stribeck", "elbow", 12.0, named=True, stands_out=False)
    before = diagnosis(waiting=(lead,))
    for nats, no in ((11.0, True), (13.0, False)):
        after = diagnosis(waiting=(replace(lead, log_bayes_factor=nats),))
        assert denies(STRIBECK, before, after) == no
    assert denies(STRIBECK, before, diagnosis())
    assert not denies(STRIBECK, before, diagnosis(findings=(finding(),)))
    between = Between(Suspect("spring", "elbow"), Suspect("ripple", "elbow"))
    assert not denies(between, before, diagnosis())


@pytest.mark.parametrize(
    ("joint", "nats", "no"), [("elbow", 30.0, False), ("elbow", 9.0, True), ("neck", 30.0, True)]
)
def test_a_motion_that_cannot_tell_it_from_another_does_not_say_no(
    joint: str, nats: float, no: bool
) -> None:
    lead = Ranked("stribeck", "elbow", 12.0, named=True, stands_out=False)
    alike = finding("spring", joint, rivals=("stribeck",), log_bayes_factor=nats)
    assert denies(STRIBECK, diagnosis(waiting=(lead,)), diagnosis(findings=(alike,))) == no


def test_a_question_is_settled_when_nothing_that_it_names_is_in_doubt() -> None:
    spring, ripple = Suspect("spring", "elbow"), Suspect("ripple", "elbow")
    between = Between(spring, ripple)
    alike = finding("spring", rivals=("ripple",), doubt=doubt())
    both = diagnosis(findings=(alike,))
    assert unsettled(between, both)
    assert not unsettled(Between(ripple, spring), both)
    assert unsettled(For(spring), both)
    for settled in ((), (finding("spring"),), (finding("ripple", doubt=doubt()),)):
        assert not unsettled(between, diagnosis(findings=settled))
        assert not unsettled(For(spring), diagnosis(findings=settled))
    assert not unsettled(Everything(), both)


def test_what_its_motion_did_not_show_is_not_told_from_its_rivals() -> None:
    found = diagnosis(findings=(finding("spring", rivals=("ripple",)),))
    spring, ripple = Suspect("spring", "elbow"), Suspect("ripple", "elbow")
    for denied, question in (([spring], None), ([ripple], Between(spring, ripple))):
        assert next_question(found, lambda: False, (), denied=denied) == question


@pytest.mark.parametrize(("nats", "question"), [(9.0, STRIBECK), (3.0, None)])
def test_a_candidate_that_nearly_stands_out_is_worth_a_motion(
    nats: float, question: object
) -> None:
    ranked = Ranked("stribeck", "elbow", nats, named=True, stands_out=False)
    curve = Ranked("curve", "shoulder", 50.0, named=False, stands_out=True)
    assert asked(diagnosis(waiting=(curve, ranked))) == question
    other = Ranked("ripple", "elbow", nats - 1.0, named=True, stands_out=False)
    assert asked(diagnosis(waiting=(ranked, other)), (STRIBECK,) * TWICE) is None
    judged = Ranked("stribeck", "elbow", 50.0, named=True, stands_out=True)
    assert asked(diagnosis(waiting=(judged,))) is None
    beside = diagnosis(waiting=(ranked,), findings=(finding("spring"),))
    assert asked(beside) == question
    found = diagnosis(waiting=(ranked,), findings=(finding("stribeck"),))
    assert asked(found) is None


def test_what_could_be_there_unseen_comes_before_what_is_faint_and_not_for_ever() -> None:
    found, everything = diagnosis(findings=(finding(doubt=doubt()),)), Everything()
    assert asked(found, unseen=True) == STRIBECK
    faint = diagnosis(waiting=(Ranked("stribeck", "elbow", 12.0, named=True, stands_out=False),))
    for before in range(MOST_EVERYTHING):
        assert asked(faint, (everything,) * before, unseen=True) == everything
    assert asked(faint, (everything,) * MOST_EVERYTHING, unseen=True) == STRIBECK
    assert asked(diagnosis(), (everything,) * MOST_EVERYTHING, unseen=True) is None


def test_motions_that_promise_too_little_are_not_worth_moving_for() -> None:
    lead = Ranked("stribeck", "elbow", 12.0, named=True, stands_out=False)
    found = diagnosis(waiting=(lead,))
    assert promising(found, made(STRIBECK, 4.1), {})  # 12 + 2 × 4.1 > 20
    assert not promising(found, made(STRIBECK, 3.9), {})
    large = diagnosis(waiting=(replace(lead, log_bayes_factor=50.0),))
    assert promising(large, made(STRIBECK, 0.51 * HOPE), {})
    assert not promising(large, made(STRIBECK, 0.49 * HOPE), {})
    assert promising(diagnosis(findings=(finding(doubt=doubt()),)), made(STRIBECK, 0.0), {})
    between = Between(Suspect("spring", "elbow"), Suspect("ripple", "elbow"))
    assert promising(found, made(between, 3.0), {})
    assert not promising(found, made(between, 1.0), {})


def test_what_else_there_is_takes_a_motion_that_shows_effects_not_seen_so_far() -> None:
    elbow = JOINTS.index("elbow")
    seen = {("stribeck", elbow): 50.0, ("ripple", elbow): 12.0}
    more = made(Everything(), 0.3, stribeck=90.0, ripple=8.1)
    assert promising(diagnosis(), more, seen)
    assert not promising(diagnosis(), made(Everything(), 0.3, stribeck=90.0, ripple=7.9), seen)
    assert not promising(diagnosis(), more, {**seen, ("ripple", elbow): 25.0})
    many = {f"effect_{k}": 50.0 for k in range(40)}
    known = {**seen, **{(name, elbow): 50.0 for name in many}}
    assert not promising(diagnosis(), made(Everything(), 0.3, ripple=8.1, **many), known)
