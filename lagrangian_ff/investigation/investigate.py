"""The loop that closes itself: move, identify, diagnose, design the next motion, until it ends."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.consequence import by_joint, errors_of, rms
from lagrangian_ff.diagnosis.excite import (
    Between,
    Design,
    Everything,
    For,
    Parameters,
    Question,
    Reference,
    Suspect,
    design,
    limits_of,
)
from lagrangian_ff.diagnosis.excite.assumed import Assumed, Key
from lagrangian_ff.diagnosis.proposing import Proposals
from lagrangian_ff.diagnosis.results import Finding
from lagrangian_ff.errors import ModelError, UserError
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.investigation.asking import (
    TWICE,
    about_formulas,
    denies,
    next_question,
    promising,
    unsettled,
)
from lagrangian_ff.investigation.looking import Look, Looking
from lagrangian_ff.investigation.motions import SHORTEST, both, first_motion, for_design, size_of
from lagrangian_ff.investigation.rig import Permit, Plan, Proposal, Rig, StoppedError
from lagrangian_ff.investigation.story import (
    Asked,
    Ended,
    Investigation,
    Listener,
    PassedOver,
    Turn,
    answered,
    asked,
)
from lagrangian_ff.investigation.unlisted import Unlisted, take_in
from lagrangian_ff.kernels.threads import one_blas_thread
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording import Motion, concatenate

MOST = 0.9
"""Share of the time that is left, for which a motion is designed: limits may make it longer."""


def investigate(
    rig: Rig,
    plan: Plan,
    permit: Permit,
    progress: Progress = silent,
    listen: Listener = lambda asked: None,
) -> Investigation:
    """Return the story of an arm that was moved until nothing was left to decide.

    Each round identifies a model of all motions so far, and diagnoses it: the first part of each
    stretch of a motion is learned from and searched, the rest confirms. What is left open is the
    next question, and the motion that decides it is designed within what was permitted. What no
    effect fits in the end is taken in as a curve if that lowers the error, and formulas are
    proposed for it; one that unseen motion confirms is added, and what is left is looked at again.

    Args:
        permit: is asked before the first motion and before each larger range.
        progress: receives the share of the budget used, and what is done.
        listen: receives each question when its motion is designed, and again with its answer.

    Raises:
        UserError: the limits leave no room, or nothing can be learned from the first motion.
    """
    story = _Story(rig, plan, permit, progress, listen)
    try:
        ended, words = story.go()
    except UserError as error:
        if not isinstance(error, StoppedError) and not story.knows:
            raise
        ended, words = Ended.STOPPED, str(error)
    return story.told(ended, words)


class _Story:
    """An investigation under way."""

    def __init__(
        self, rig: Rig, plan: Plan, permit: Permit, progress: Progress, listen: Listener
    ) -> None:
        self._rig, self._plan, self._permit, self._progress = rig, plan, permit, progress
        self._listen, self._asked = listen, Asked("", 0.0)
        self._start = rig.pose() if plan.start is None else plan.start
        self._limits = plan.limits
        self._looking = Looking(rig.joints, plan.model, plan.conditioning, self._say)
        self._motions: list[tuple[Question | None, Reference, Design | None]] = []
        self._looks: list[Look] = []
        self._assumed: Assumed | None = None
        self._denied: list[Suspect] = []
        self._passed_over: list[PassedOver] = []
        self._first_motions = 0
        self._used = 0.0
        self._leaves: tuple[Look, Unlisted | None] | None = None
        self._proposed: dict[str, Proposals] = {}

    @property
    def knows(self) -> bool:
        """Return whether anything is known yet."""
        return bool(self._looks)

    def go(self) -> tuple[Ended, str]:
        """Move and look until it ends; return why it ended."""
        for number, share in enumerate(self._plan.reaches):
            seconds = min(self._plan.first, self._left)
            if seconds < SHORTEST:
                if number == 0:
                    return Ended.BUDGET, Ended.BUDGET.value
                break
            if not self._may_go(share):
                if number == 0:
                    return Ended.REFUSED, Ended.REFUSED.value
                break
            seed, clear = self._plan.seed + number, self._plan.clear
            motion = first_motion(
                self._rig.joints, self._limits, self._start, seconds, seed=seed, clear=clear
            )
            self._move(motion, None, None)
            self._first_motions += 1
        look = self._looked()
        questions: list[Question] = []
        while True:
            question = self._next(look, questions)
            if self._named(question):
                look = self._looks[-1]
                continue
            question = self._between_formulas(question, questions)
            if question is None:
                return Ended.NOTHING_LEFT, Ended.NOTHING_LEFT.value
            seconds = min(self._plan.each, self._left)
            if seconds < SHORTEST:
                return Ended.BUDGET, Ended.BUDGET.value
            questions.append(question)
            try:
                made = self._designed(look, question, min(seconds, MOST * self._left))
            except ModelError as error:  # no motion within the limits answers it: the next one
                self._say(str(error))
                self._pass_over(question, None)
                continue
            if not promising(look.diagnosis, made, self._seen):
                every = isinstance(question, Everything)
                told = "shows much more" if every else f"settles it: {made.nats:.1f} nats expected"
                self._say(f"no motion {told}")
                self._pass_over(question, made.nats)
                questions += [question] * TWICE
                continue
            if float(made.reference.time[-1]) > self._left:
                return Ended.BUDGET, Ended.BUDGET.value
            self._move(made.reference, question, made)
            before, look = look, self._looked()
            if denies(question, before.diagnosis, look.diagnosis):
                questions.append(question)
                if isinstance(question, For) and made.nats >= thresholds.USED.floor:
                    self._denied.append(question.suspect)

    def told(self, ended: Ended, words: str) -> Investigation:
        """Return the story so far, all models judged on the same unseen motion."""
        # What came after the last look could not be read, or was not looked at before a stop.
        del self._looking.recordings[max(0, self._first_motions + len(self._looks) - 1) :]
        if ended is Ended.BUDGET:
            try:
                self._named(None)
            except UserError as error:  # what is known is kept
                ended, words = Ended.STOPPED, str(error)
        turns, before = self._turns()
        over, used = self._left_open(), self._used
        found = Investigation(self._rig.joints, turns, ended, words, used, *before, over)
        return self._with_unlisted(found) if turns and self._plan.unlisted else found

    def _turns(self) -> tuple[tuple[Turn, ...], tuple[dict[str, float], float]]:
        """Return the turns, and the errors of the last model without what was found."""
        if not self._looks:
            return (), ({}, 0.0)
        _, unseen = self._looking.parts()
        turns, used = list[Turn](), 0.0
        # The first motions are looked at together: they are one turn.
        moved = self._motions[self._first_motions - 1 :]
        for (question, motion, made), look in zip(moved, self._looks, strict=False):
            errors, total = _errors(look.model, unseen)
            known = look.diagnosis, look.model, look.answer, errors, total
            turns.append(Turn(question, motion, look.used - used, made, *known))
            used = look.used
        return tuple(turns), _errors(self._looks[-1].base, unseen)

    def _with_unlisted(self, found: Investigation) -> Investigation:
        """Return the story with what no effect fits: formulas that were added, and the rest."""
        left: Unlisted | None = None
        if found.ended is not Ended.STOPPED:
            try:
                left = self._taken_in()
            except UserError as error:  # what is known is kept
                found = replace(found, ended=Ended.STOPPED, words=str(error))
        added = tuple(self._proposed.values())
        if left is None and not added:
            return found
        left = (left or Unlisted((), (), found.turns[-1].model, ())).beside(added)
        errors, total = _errors(left.model, self._looking.parts()[1])
        return replace(found, unlisted=left, errors=errors, total=total)

    def _taken_in(self) -> Unlisted | None:
        """Return what no effect fits at the last look."""
        last = self._looks[-1]
        if self._leaves is None or self._leaves[0] is not last:
            learned, unseen = self._looking.parts()
            self._say("looking at what no effect fits")
            with one_blas_thread():
                self._leaves = last, take_in(last.diagnosis, learned, unseen)
        return self._leaves[1]

    def _named(self, question: Question | None) -> bool:
        """Look again with formulas that are confirmed for what no effect fits, if there are any.

        What no effect fits hides the rest, and pulls the model: it is named as soon as possible.
        Where not even its coordinate is known, that waits until no other question is left.

        Args:
            question: to be asked next; None for none.
        """
        *before, last = self._looks
        ripe = last.diagnosis.unexplained or _last(question)
        left = self._taken_in() if self._plan.unlisted and ripe else None
        if left is None:
            return False
        names = self._rig.joints
        new = [term for term in left.terms if names[term.joint] not in self._proposed]
        if not new:
            return False
        for term in new:
            joint = names[term.joint]
            self._proposed[joint] = next(one for one in left.proposals if one.joint == joint)
        self._looks = [*before, self._look(before, (*last.found, *new))]
        return True

    def _between_formulas(
        self, question: Question | None, asked_before: Sequence[Question]
    ) -> Question | None:
        """Return which of two formulas is there, if both hold and all else is asked."""
        if self._plan.unlisted and _last(question):
            self._taken_in()
            return about_formulas(self._formulas, asked_before) or question
        return question

    @property
    def _formulas(self) -> tuple[tuple[Between, Finding], ...]:
        """Return the questions about formulas that are open, see `Unlisted.open`."""
        left = self._leaves[1] if self._leaves else None
        return left.open if left else ()

    def _pass_over(self, question: Question, expected: float | None) -> None:
        others = [one for one in self._passed_over if one.question != question]
        self._passed_over = [*others, PassedOver(question, expected)]

    def _left_open(self) -> tuple[PassedOver, ...]:
        """Return the questions that no motion settles, of those that are open in the end."""
        if not self._looks:
            return ()
        last = self._looks[-1].diagnosis
        moved = [question for question, _, _ in self._motions]
        left = [one for one in self._passed_over if one.question not in moved]
        formulas = [question for question, _ in self._formulas]
        return tuple(
            one for one in left if one.question in formulas or unsettled(one.question, last)
        )

    @property
    def _seen(self) -> Mapping[Key, float]:
        """Return by effect and joint the nats that the motions so far would show, once asked."""
        return {} if self._assumed is None else self._assumed.seen(self._plan.size)

    @property
    def _left(self) -> float:
        return self._plan.budget - self._used

    def _may_go(self, share: float) -> bool:
        limits = self._plan.limits.around(self._start, share)
        proposal = Proposal(self._rig.joints, self._start, limits, share, self._left)
        if not self._permit(proposal):
            return False
        self._limits = limits
        return True

    def _move(self, motion: Reference, question: Question | None, made: Design | None) -> None:
        seconds = float(motion.time[-1])
        begin = self._used / self._plan.budget
        here = part(self._progress, begin, min(1.0, begin + seconds / self._plan.budget))
        here(0.0, f"moving for {seconds:.0f} s: {asked(question)}")
        self._asked = Asked(asked(question), seconds, made.nats if made else None)
        self._listen(self._asked)
        known = self._looks[-1].model if self._looks else None
        self._looking.recordings.append(self._rig.run(motion, known, here))
        self._motions.append((question, motion, made))
        self._used += seconds

    def _looked(self) -> Look:
        """Look at all motions so far, and return what is seen."""
        known = self._looks[-1].found if self._looks else ()
        self._looks.append(self._look(self._looks, known))
        return self._looks[-1]

    def _look(self, before: Sequence[Look], known: Sequence[Term]) -> Look:
        """Return a look at all motions so far, and tell the answer.

        Args:
            before: the looks at fewer motions.
            known: what is taken to be there, unless these motions are against it.
        """
        last = before[-1] if before else None
        look = self._looking.look(known, last.stretches if last else 0)
        answer = answered(self._motions[-1][0], look.diagnosis, last.confirmed if last else ())
        self._assumed = None
        self._listen(replace(self._asked, answer=answer, confirmed=look.confirmed))
        return replace(look, answer=answer, used=self._used)

    def _next(self, look: Look, asked_before: Sequence[Question]) -> Question | None:
        def unseen() -> bool:
            with one_blas_thread():
                self._assumed = Assumed.of(for_design(look.diagnosis, Everything(), look.made))
            return any(nats < thresholds.USED.floor for nats in self._seen.values())

        gears = self._plan.gears
        return next_question(look.diagnosis, unseen, asked_before, gears, self._denied)

    def _designed(self, look: Look, question: Question, seconds: float) -> Design:
        self._say(f"designing a motion: {asked(question)}")
        model = for_design(look.diagnosis, question, look.made)
        every = isinstance(question, Everything)
        found = (*look.diagnosis.findings, *(one for _, one in self._formulas))
        return design(
            model,
            question,
            both(self._limits, limits_of(model), self._start),
            start=self._start,
            seconds=seconds,
            size=self._plan.size if every else size_of(found, question, model),
            clear=self._plan.clear,
            assumed=self._assumed if every else _beside(model, question),
            seed=self._plan.seed + len(self._motions),
        )

    def _say(self, what: str) -> None:
        self._progress(min(1.0, self._used / self._plan.budget), what)


def _beside(model: Model, question: Question) -> Assumed | None:
    """Return what is assumed of an arm where a formula is there, or its rival; None for effects."""
    one = question.suspects[0] if question.suspects else None
    if one is None or one.formula is None:
        return None
    term = Term(one.formula, model.joints.index(one.joint), one.shape)
    with one_blas_thread():
        return Assumed.of(model, there=[term])


def _last(question: Question | None) -> bool:
    """Return whether nothing else is left to ask."""
    return question is None or isinstance(question, Parameters)


def _errors(model: Model, unseen: Sequence[Motion]) -> tuple[dict[str, float], float]:
    left = errors_of(model, concatenate(unseen))
    return by_joint(model, left), rms(left)
