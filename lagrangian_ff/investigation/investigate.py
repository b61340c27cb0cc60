"""The loop that closes itself: move, identify, diagnose, design the next motion, until it ends."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from lagrangian_ff.diagnosis import apply, diagnose, thresholds, with_consequences
from lagrangian_ff.diagnosis.consequence import by_joint, errors_of, rms
from lagrangian_ff.diagnosis.excite import (
    Design,
    Everything,
    For,
    Question,
    Reference,
    Suspect,
    design,
    limits_of,
)
from lagrangian_ff.diagnosis.excite.assumed import Assumed, Key
from lagrangian_ff.diagnosis.results import Diagnosis
from lagrangian_ff.errors import ModelError, UserError
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.identification.settings import usual_model
from lagrangian_ff.investigation.asking import TWICE, denies, next_question, promising, unsettled
from lagrangian_ff.investigation.motions import (
    SHORTEST,
    Named,
    both,
    first_motion,
    for_design,
    size_of,
)
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
from lagrangian_ff.investigation.stretches import closely, learned_and_unseen
from lagrangian_ff.investigation.unlisted import take_in
from lagrangian_ff.kernels.threads import one_blas_thread
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording import Motion, Recording, concatenate, condition_alike

MOST = 0.9
"""Share of the time that is left, for which a motion is designed: limits may make it longer."""


@dataclass(frozen=True)
class _Look:
    """A model of all motions so far, and what it lacks.

    Attributes:
        base: the model that was diagnosed.  diagnosis: of that model.
        model: `base` with what is confirmed.
        used: s of motion so far.
        made: the models that motions were designed with; `for_design` fits none of them twice.
    """

    base: Model
    diagnosis: Diagnosis
    model: Model
    used: float
    made: dict[tuple[Named, ...], Model] = field(default_factory=dict)

    @property
    def found(self) -> tuple[Term, ...]:
        """Return the effects that were confirmed."""
        return self.model.basis.terms[len(self.base.basis.terms) :]


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
    proposed for it.

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
        self._recordings: list[Recording] = []
        self._conditioning = plan.conditioning
        self._motions: list[tuple[Question | None, Reference, Design | None]] = []
        self._looks: list[_Look] = []
        self._assumed: Assumed | None = None
        self._denied: list[Suspect] = []
        self._passed_over: list[PassedOver] = []
        self._first_motions = self._known = 0
        self._used = 0.0

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
        look = self._look()
        questions: list[Question] = []
        while True:
            question = self._next(look, questions)
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
            before, look = look, self._look()
            if denies(question, before.diagnosis, look.diagnosis):
                questions.append(question)
                if isinstance(question, For) and made.nats >= thresholds.USED.floor:
                    self._denied.append(question.suspect)

    def told(self, ended: Ended, words: str) -> Investigation:
        """Return the story so far, all models judged on the same unseen motion."""
        turns: list[Turn] = []
        before: tuple[dict[str, float], float] = ({}, 0.0)
        if self._looks:
            _, unseen = self._parts()
            # The first motions are looked at together: they are one turn.
            moved = self._motions[self._first_motions - 1 :]
            before, used = _errors(self._looks[-1].base, unseen), 0.0
            for (question, motion, made), look in zip(moved, self._looks, strict=False):
                errors, total = _errors(look.model, unseen)
                known = look.diagnosis, look.model, errors, total
                turns.append(Turn(question, motion, look.used - used, made, *known))
                used = look.used
        left = self._left_open()
        found = Investigation(
            self._rig.joints, tuple(turns), ended, words, self._used, *before, left
        )
        if ended is Ended.STOPPED or not turns or not self._plan.unlisted:
            return found
        try:
            return self._with_unlisted(found)
        except StoppedError as error:  # what is known is kept
            return replace(found, ended=Ended.STOPPED, words=str(error))

    def _with_unlisted(self, found: Investigation) -> Investigation:
        """Return the story with what no effect fits, as curves and formulas."""
        learned, unseen = self._parts()
        self._say("looking at what no effect fits")
        with one_blas_thread():
            left = take_in(self._looks[-1].diagnosis, learned, unseen)
        if left is None:
            return found
        errors, total = _errors(left.model, unseen)
        return replace(found, unlisted=left, errors=errors, total=total)

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
        return tuple(one for one in left if unsettled(one.question, last))

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
        self._recordings.append(self._rig.run(motion, known, here))
        self._motions.append((question, motion, made))
        self._used += seconds

    def _look(self) -> _Look:
        learned, unseen = self._parts()
        base, found = self._diagnosed(learned, unseen)
        if (lag := found.lag) is not None:
            self._conditioning = lag.applied(self._conditioning)
            learned, unseen = self._parts()
            base, found = self._diagnosed(learned, unseen)
            found = replace(found, lag=lag)
        with one_blas_thread():
            found = with_consequences(found, confirmed_only=True)
        self._known = len(learned)
        look, self._assumed = _Look(base, found, apply(found), self._used), None
        self._looks.append(look)
        names = tuple(one.name for one, _ in found.tried)
        answer = answered(self._motions[-1][0], found)
        self._listen(replace(self._asked, answer=answer, confirmed=names))
        return look

    def _diagnosed(
        self, learned: Sequence[Motion], unseen: Sequence[Motion]
    ) -> tuple[Model, Diagnosis]:
        """Return a model of what is learned from, and what it lacks."""
        self._say("identifying a model")
        name = self._plan.model or usual_model(self._plan.conditioning.effort)
        base = identify(learned, Settings(model=name, train=1.0)).model
        self._say("looking for what is missing")
        with one_blas_thread():
            found = diagnose(
                base,
                self._newest_closely(learned),
                self._newest_closely(unseen),
                known=self._looks[-1].found if self._looks else (),
            )
        return base, found

    def _next(self, look: _Look, asked_before: Sequence[Question]) -> Question | None:
        def unseen() -> bool:
            with one_blas_thread():
                self._assumed = Assumed.of(for_design(look.diagnosis, Everything(), look.made))
            return any(nats < thresholds.USED.floor for nats in self._seen.values())

        gears = self._plan.gears
        return next_question(look.diagnosis, unseen, asked_before, gears, self._denied)

    def _designed(self, look: _Look, question: Question, seconds: float) -> Design:
        self._say(f"designing a motion: {asked(question)}")
        model = for_design(look.diagnosis, question, look.made)
        every = isinstance(question, Everything)
        return design(
            model,
            question,
            both(self._limits, limits_of(model), self._start),
            start=self._start,
            seconds=seconds,
            size=self._plan.size if every else size_of(look.diagnosis, question, model),
            clear=self._plan.clear,
            assumed=self._assumed if every else None,
            seed=self._plan.seed + len(self._motions),
        )

    def _parts(self) -> tuple[list[Motion], list[Motion]]:
        """Return what is learned from and searched of each motion, and what is not."""
        motions = condition_alike(self._recordings, self._conditioning)
        return learned_and_unseen([motion.select(self._rig.joints) for motion in motions])

    def _newest_closely(self, stretches: Sequence[Motion]) -> list[Motion]:
        """Return the stretches; those since the last look, for a question, are looked at closely.

        They would drown in all that came before.
        """
        new = stretches[self._known :]
        return [*stretches[: self._known], *(closely(one) for one in new)]

    def _say(self, what: str) -> None:
        self._progress(min(1.0, self._used / self._plan.budget), what)


def _errors(model: Model, unseen: Sequence[Motion]) -> tuple[dict[str, float], float]:
    left = errors_of(model, concatenate(unseen))
    return by_joint(model, left), rms(left)
