"""The next question: what is open, what is usual first, and never without end."""

from dataclasses import replace

import pytest
from diagnosis_examples import JOINTS, diagnosis, doubt, finding

from lagrangian_ff.diagnosis.excite import Between, Everything, For, Suspect
from lagrangian_ff.diagnosis.observable import Observability
from lagrangian_ff.diagnosis.results import Diagnosis, Doubt, Ranked, Reason
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.investigation import next_question
from lagrangian_ff.investigation.asking import HOPE, MOST_EVERYTHING, TWICE, promising

SIZE = 0.03
SEEN = Observability(JOINTS, {"stribeck": (0.01, 0.02)}, (), SIZE)
UNSEEN = Observability(JOINTS, {"stribeck": (0.01, 0.2)}, (), SIZE)
NEVER = Observability(JOINTS, {"stribeck": (0.01, float("inf"))}, (), SIZE)
STRIBECK = For(Suspect("stribeck", "elbow"))


def asked(found: Diagnosis, shown: Observability = SEEN, before: tuple[object, ...] = ()) -> object:
    return next_question(found, lambda: shown, before, SIZE)  # type: ignore[arg-type]


def test_a_confirmed_effect_leaves_nothing_open() -> None:
    assert asked(diagnosis(findings=(finding(),))) is None
    assert asked(diagnosis()) is None


def test_a_suggested_effect_is_asked_for() -> None:
    found = diagnosis(findings=(finding(doubt=doubt()),))
    assert asked(found) == STRIBECK


def test_what_is_there_but_lowers_no_error_is_asked_for_last() -> None:
    there = finding(doubt=Doubt(Reason.NO_HELP, "it does not lower the error"))
    lead = Ranked("ripple", "shoulder", 15.0, named=True, stands_out=False)
    both = diagnosis(findings=(there,), waiting=(lead,))
    first = For(Suspect("ripple", "shoulder"))
    assert asked(both) == first
    assert asked(both, SEEN, (first,) * TWICE) == STRIBECK
    assert asked(both, SEEN, (first, STRIBECK) * TWICE) is None


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
        while (question := next_question(found, lambda: SEEN, before, SIZE, gears)) is not None:
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
    assert asked(both, SEEN, (between,) * TWICE) is None
    alone = diagnosis(findings=(finding("spring", rivals=("contact",), doubt=doubt()),))
    assert asked(alone) == For(Suspect("spring", "elbow"))
    touch = Ranked("contact", "elbow", 50.0, named=True, stands_out=True)
    assert asked(diagnosis(waiting=(touch,))) is None


def test_one_question_is_asked_twice_at_most() -> None:
    found = diagnosis(findings=(finding(doubt=doubt()),))
    assert asked(found, SEEN, (STRIBECK,)) == STRIBECK
    assert asked(found, SEEN, (STRIBECK,) * TWICE) is None


@pytest.mark.parametrize(("nats", "question"), [(9.0, STRIBECK), (3.0, None)])
def test_a_candidate_that_nearly_stands_out_is_worth_a_motion(
    nats: float, question: object
) -> None:
    ranked = Ranked("stribeck", "elbow", nats, named=True, stands_out=False)
    curve = Ranked("curve", "shoulder", 50.0, named=False, stands_out=True)
    assert asked(diagnosis(waiting=(curve, ranked))) == question
    other = Ranked("ripple", "elbow", nats - 1.0, named=True, stands_out=False)
    assert asked(diagnosis(waiting=(ranked, other)), SEEN, (STRIBECK,) * TWICE) is None
    judged = Ranked("stribeck", "elbow", 50.0, named=True, stands_out=True)
    assert asked(diagnosis(waiting=(judged,))) is None
    beside = diagnosis(waiting=(ranked,), findings=(finding("spring"),))
    assert asked(beside) == question
    found = diagnosis(waiting=(ranked,), findings=(finding("stribeck"),))
    assert asked(found) is None


def test_what_could_be_there_unseen_is_asked_for_last_and_not_for_ever() -> None:
    found, everything = diagnosis(findings=(finding(doubt=doubt()),)), Everything()
    assert asked(found, UNSEEN) == STRIBECK
    assert asked(diagnosis(), UNSEEN) == everything
    assert asked(diagnosis(), UNSEEN, (everything,) * (MOST_EVERYTHING - 1)) == everything
    assert asked(diagnosis(), UNSEEN, (everything,) * MOST_EVERYTHING) is None
    assert asked(diagnosis(), NEVER) is None  # no motion shows it


def test_motions_that_promise_too_little_are_not_worth_moving_for() -> None:
    lead = Ranked("stribeck", "elbow", 12.0, named=True, stands_out=False)
    found = diagnosis(waiting=(lead,))
    assert promising(found, STRIBECK, 4.1)  # 12 + 2 × 4.1 > 20
    assert not promising(found, STRIBECK, 3.9)
    large = diagnosis(waiting=(replace(lead, log_bayes_factor=50.0),))
    assert promising(large, STRIBECK, 0.51 * HOPE)
    assert not promising(large, STRIBECK, 0.49 * HOPE)
    assert promising(diagnosis(findings=(finding(doubt=doubt()),)), STRIBECK, 0.0)
    between = Between(Suspect("spring", "elbow"), Suspect("ripple", "elbow"))
    assert promising(found, between, 3.0)
    assert not promising(found, between, 1.0)
    assert promising(found, Everything(), 0.3)
