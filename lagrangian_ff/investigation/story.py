"""What an investigation did and found, turn by turn."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from lagrangian_ff.diagnosis import verdict
from lagrangian_ff.diagnosis.excite import (
    Between,
    Design,
    Everything,
    For,
    Parameters,
    Question,
    Reference,
)
from lagrangian_ff.diagnosis.results import Diagnosis, Finding, Unexplained
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import Model
from lagrangian_ff.investigation.unlisted import Unlisted
from lagrangian_ff.record_json import finite
from lagrangian_ff.words import listed, sentence, spoken


class Ended(str, Enum):
    """Why an investigation ended; JSON holds the value."""

    NOTHING_LEFT = "nothing is left that another motion could decide"
    BUDGET = "the time for motion is used"
    REFUSED = "the motion was not permitted"
    STOPPED = "the arm was stopped"


@dataclass(frozen=True)
class Asked:
    """A question under way.

    Attributes:
        words: the question.
        seconds: of the motion that is to answer it.
        expected: nats that the motion is expected to gain; None for a motion of a kind.
        answer: the verdict after it, in words; empty before.
        confirmed: what is confirmed by then, in words.
    """

    words: str
    seconds: float
    expected: float | None = None
    answer: str = ""
    confirmed: tuple[str, ...] = ()


Listener = Callable[[Asked], None]
"""Receives what an investigation asks, and what the answer is."""


@dataclass(frozen=True)
class PassedOver:
    """A question that was left open, since no motion within the limits settles it.

    Attributes:
        question: what was not asked.
        expected: nats that the best motion would gain; None if no motion could be designed.
    """

    question: Question
    expected: float | None

    @property
    def said(self) -> str:
        """Return it in words."""
        if self.expected is None:
            return f"{asked(self.question)} No motion within the limits shows it."
        return (
            f"{asked(self.question)} No motion within the limits settles it: the best would gain "
            f"{self.expected:.1f} nats. More range or speed may."
        )


@dataclass(frozen=True, eq=False)
class Turn:
    """A motion, and what is known after it.

    Attributes:
        question: that the motion was to answer; None for the first ones.
        motion: as it was sent; of the first ones, which are looked at together, the last.
        seconds: of all motion since the turn before.
        design: how it was found; None for a motion of a kind.
        diagnosis: of all motions so far, with consequences.
        model: with all that is confirmed.
        answer: to the question, and the verdict of the diagnosis, in words.
        errors: by joint, N·m rms of that model on the part of all motions of the investigation that
            no model learned from; so that turns compare.
        total: the same over all joints.
    """

    question: Question | None
    motion: Reference
    seconds: float
    design: Design | None
    diagnosis: Diagnosis
    model: Model
    answer: str
    errors: Mapping[str, float]
    total: float

    @property
    def asked(self) -> str:
        """Return the question in words."""
        return asked(self.question)

    @property
    def confirmed(self) -> tuple[Finding, ...]:
        """Return what is confirmed and lowers the error."""
        return tuple(finding for finding, _ in self.diagnosis.tried)

    @property
    def expected(self) -> float | None:
        """Return the nats that the motion was expected to gain for its question."""
        return None if self.design is None else self.design.nats

    @property
    def gained(self) -> float | None:
        """Return the nats for what was asked for, of all motions; None if it was not found."""
        suspects = of_question(self.question)
        for one in self.diagnosis.findings:
            if (one.effect.name, one.joint) in suspects:
                return one.log_bayes_factor
        return None


@dataclass(frozen=True, eq=False)
class Investigation:
    """The whole story.

    Attributes:
        joints: N names.
        turns: in their order.
        ended, words: why it ended, for a program and in words.
        seconds: of motion.
        before: by joint, N·m rms of the last model without any effect that was found, on the same
            motion as the turns' errors; empty without a turn.
        before_total: the same over all joints.
        passed_over: questions that are open still, and that no motion within the limits settles.
        unlisted: what no effect of the catalogue fits; None for nothing.
        errors, total: as of a turn, of the model with the curves of that.
    """

    joints: tuple[str, ...]
    turns: tuple[Turn, ...]
    ended: Ended
    words: str
    seconds: float
    before: Mapping[str, float]
    before_total: float
    passed_over: tuple[PassedOver, ...] = ()
    unlisted: Unlisted | None = None
    errors: Mapping[str, float] = field(default_factory=dict)
    total: float = 0.0

    @property
    def curves(self) -> tuple[Unexplained, ...]:
        """Return what the model holds as curves."""
        return self.unlisted.taken if self.unlisted else ()

    @property
    def model(self) -> Model | None:
        """Return the last model, with its curves; None without a turn."""
        if self.unlisted and self.curves:
            return self.unlisted.model
        return self.turns[-1].model if self.turns else None

    @property
    def confirmed(self) -> tuple[Finding, ...]:
        """Return what is confirmed in the end."""
        return self.turns[-1].confirmed if self.turns else ()

    @property
    def formulas(self) -> tuple[Finding, ...]:
        """Return those that were proposed here, for what no effect of the catalogue fits."""
        return tuple(one for one in self.confirmed if one.effect.name not in EFFECTS)

    @property
    def left(self) -> tuple[str, ...]:
        """Return what is unexplained, not confirmed or not asked in the end, in sentences."""
        if not self.turns:
            return ()
        last, curves = self.turns[-1].diagnosis, {one.joint for one in self.curves}
        return (
            *(
                f"On {one.joint} something is left that depends on {one.coordinate}: "
                + (
                    "the model holds it as a curve."
                    if one.joint in curves
                    else "a curve does not lower the error."
                )
                for one in last.unexplained
            ),
            *(
                sentence(f"{spoken(one.name)} is no more than {one.said}")
                for one in last.findings
                if not one.confirmed
            ),
            *(one.said for one in self.passed_over),
        )

    def record(self) -> dict[str, Any]:
        """Return the story for JSON."""
        return finite({
            "joints": list(self.joints),
            "ended": self.ended.value,
            "words": self.words,
            "seconds": self.seconds,
            "before": {"errors": dict(self.before), "rmse": self.before_total},
            "turns": [
                {
                    "asked": turn.asked,
                    "seconds": turn.seconds,
                    "expected_nats": turn.expected,
                    "gained_nats": turn.gained,
                    "answer": turn.answer,
                    "confirmed": [one.name for one in turn.confirmed],
                    "findings": [_finding(one) for one in turn.diagnosis.findings],
                    "unexplained": [_unexplained(one) for one in turn.diagnosis.unexplained],
                    "errors": dict(turn.errors),
                    "rmse": turn.total,
                }
                for turn in self.turns
            ],
            "passed_over": [
                {"question": asked(one.question), "expected_nats": one.expected}
                for one in self.passed_over
            ],
            "unlisted": self.unlisted and {
                **self.unlisted.record(), "errors": dict(self.errors), "rmse": self.total
            },
        })  # fmt: skip


def _finding(found: Finding) -> dict[str, Any]:
    return {
        "effect": found.effect.name,
        "joint": found.joint,
        "verdict": found.verdict.value,
        "log_bayes_factor": found.log_bayes_factor,
        "rivals": list(found.rivals),
    }


def _unexplained(one: Unexplained) -> dict[str, Any]:
    names = ("joint", "coordinate", "share", "log_bayes_factor")
    return {name: getattr(one, name) for name in names}


def of_question(question: Question | None) -> tuple[tuple[str, str], ...]:
    """Return the effects and joints that a question names."""
    if isinstance(question, For):
        return ((question.suspect.effect, question.suspect.joint),)
    if isinstance(question, Between):
        return tuple((one.effect, one.joint) for one in (question.first, question.second))
    return ()


def answered(question: Question | None, found: Diagnosis, known: Collection[str] = ()) -> str:
    """Return the answer to a question, and the verdict of the diagnosis, in words.

    Args:
        known: names of what was confirmed before the question.
    """
    direct, said = _direct(question, found, known), verdict(found)
    return f"{direct} {sentence(said)}" if direct else said


def _direct(question: Question | None, found: Diagnosis, known: Collection[str]) -> str:
    """Return what became of the effects that a question names, in words."""
    suspects = of_question(question)
    several = len(suspects) > 1
    of_them = [one for one in found.findings if (one.effect.name, one.joint) in suspects]
    added = [one.name for one, _ in found.tried]
    if isinstance(question, Everything):
        new = [spoken(name) for name in added if name not in known]
        return f"New: {listed(new)}." if new else "Nothing new is confirmed."
    if isinstance(question, Parameters):
        still = [f"{error:.2g} N·m on {joint}" for joint, error in found.failing.items()]
        return f"The model still misses {listed(still)}." if still else "The model knows it now."
    for one in of_them:
        if one.name in added:
            return f"It is {spoken(one.name)}." if several else "Yes."
    if of_them:
        return f"{sentence(spoken(of_them[0].name))[:-1]} is no more than {of_them[0].said}."
    for one in found.findings:
        if any(one.joint == joint and effect in one.rivals for effect, joint in suspects):
            return f"It may be that, or {spoken(one.name)}."
    if isinstance(question, Between) and question.first.formula is not None:
        return "It is open still."
    if several:
        return "Neither shows."
    return "It does not show." if suspects else ""


def asked(question: Question | None) -> str:
    """Return a question in words."""
    if isinstance(question, For):
        return f"Is there {spoken(question.suspect.effect)} on {question.suspect.joint}?"
    if isinstance(question, Between):
        first, second = question.first, question.second
        return f"Is it {spoken(first.effect)} or {spoken(second.effect)} on {first.joint}?"
    if isinstance(question, Everything):
        return "What else is there, that the motions so far do not show?"
    if isinstance(question, Parameters):
        return "How heavy is the arm? The model fails on unseen motion."
    return "What does the arm do?"
