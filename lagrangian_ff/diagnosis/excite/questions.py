"""Questions that a motion answers, and the cases that an answer must settle."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.excite.assumed import SHAPES, Assumed, creeps, spread
from lagrangian_ff.diagnosis.search.candidates import Candidate, bends_over_speed
from lagrangian_ff.effects import EFFECTS, Effect, look_alikes
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.samples import evenly

RIVAL_SHAPES = 6
"""Shapes of a rival that are tried; it may take the best of them."""
FEWEST, MOST = 8, 16
"""Effects that a motion for everything looks at, at least and at most."""


@dataclass(frozen=True)
class Suspect:
    """An effect on a joint.

    Attributes:
        effect, joint: their names.
        shape: its nonlinear parameters, if known; else a few shapes stand for all.
        formula: the effect, where it is a formula that the catalogue lacks.
    """

    effect: str
    joint: str
    shape: Mapping[str, float] = field(default_factory=dict)
    formula: Effect | None = field(default=None, compare=False, repr=False)

    @classmethod
    def parse(cls, text: str) -> "Suspect":
        """Return the suspect that a text such as stribeck@joint_2 names.

        Raises:
            ModelError: it is of another form.
        """
        effect, at, joint = text.partition("@")
        if not (effect and at and joint):
            raise ModelError(f"{text}: expected EFFECT@JOINT, as in stribeck@joint_2")
        return cls(effect, joint)

    @property
    def known(self) -> Effect:
        """Return the effect.

        Raises:
            ModelError: there is none of this name.
        """
        if self.formula is not None:
            return self.formula
        if self.effect not in EFFECTS:
            raise ModelError(f"there is no effect '{self.effect}'; lagrangian_ff effects lists all")
        return EFFECTS[self.effect]

    def __str__(self) -> str:
        return f"{self.effect}@{self.joint}"


@dataclass(frozen=True)
class For:
    """Is this effect there, and none of its look-alikes instead?"""

    suspect: Suspect

    @property
    def suspects(self) -> tuple[Suspect, ...]:
        """Return the effects asked about."""
        return (self.suspect,)


@dataclass(frozen=True)
class Between:
    """Which of two is there?"""

    first: Suspect
    second: Suspect

    @property
    def suspects(self) -> tuple[Suspect, ...]:
        """Return the effects asked about."""
        return self.first, self.second


@dataclass(frozen=True)
class Everything:
    """What is there, of all that the model's own data do not show, and how much of it?"""

    @property
    def suspects(self) -> tuple[Suspect, ...]:
        """Return the effects asked about."""
        return ()


@dataclass(frozen=True)
class Parameters:
    """What are the arm's masses and inertias? Their uncertainty shall be least (D-optimal)."""

    @property
    def suspects(self) -> tuple[Suspect, ...]:
        """Return the effects asked about."""
        return ()


Question = For | Between | Everything | Parameters


@dataclass(frozen=True)
class Case:
    """One effect that may be there, and what may imitate it.

    Attributes:
        true: the effect, in one shape.
        rivals: each may imitate it alone, with free parameters; None is the plain model.
    """

    true: Candidate
    rivals: tuple[Candidate | None, ...]


def cases_of(question: Question, assumed: Assumed, size: float) -> list[list[Case]]:
    """Return groups of cases: the least of the groups counts, of a group the mean.

    A question about the parameters has none.

    Args:
        size: of the effects, which decides what the model's own data do not show.

    Raises:
        ModelError: an effect or a joint that is not there, an effect that the model has, or that no
            motion shows.
    """
    if isinstance(question, For):
        alike = [
            one
            for name in look_alikes(_checked(question.suspect, assumed).known)
            for one in _shapes(Suspect(name, question.suspect.joint), assumed, RIVAL_SHAPES)
        ]
        true = _seen_shapes(question.suspect, assumed, SHAPES)
        return [[Case(one, (None, *alike)) for one in true]]
    if isinstance(question, Between):
        both = (question.first, question.second)
        for one in both:
            _checked(one, assumed)
        ways = (both, both[::-1])
        return [
            [
                Case(one, tuple(_shapes(other, assumed, RIVAL_SHAPES)))
                for one in _seen_shapes(true, assumed, SHAPES)
            ]
            for true, other in ways
        ]
    if isinstance(question, Parameters):
        return []
    return [[Case(one, (None,)) for one in _hidden(assumed, size)]]


def shown_by_motion(effect: Effect) -> bool:
    """Return whether some motion shows an effect: not an event, nor what none ever shows."""
    return effect.observable and effect.kind != "event"


def creeping_in(question: Question, joints: Sequence[str]) -> list[int]:
    """Return the joints of which a question asks how friction bends over speed."""
    if isinstance(question, Everything):
        return list(range(len(joints)))
    bending = (one for one in question.suspects if bends_over_speed(one.known))
    return sorted({joints.index(one.joint) for one in bending})


def _hidden(assumed: Assumed, size: float) -> list[Candidate]:
    """Return effects that the model's own data would not show, from the least shown to the most.

    They stand for all of these: of those shown least alone, many are shown by no motion.
    """
    seen = assumed.seen(size)
    least = sorted(seen, key=lambda key: seen[key])
    count = sum(nats < thresholds.USED.floor for nats in seen.values())
    hidden = least[: max(count, FEWEST)]
    joints = assumed.model.joints
    return [
        one
        for name, n in (hidden[place] for place in evenly(len(hidden), MOST))
        for one in _seen_shapes(Suspect(name, joints[n]), assumed, 1)
    ]


def _checked(suspect: Suspect, assumed: Assumed) -> Suspect:
    effect = suspect.known
    known = {shape.name for shape in effect.shapes}
    if strange := [name for name in suspect.shape if name not in known]:
        raise ModelError(
            f"{suspect} has no shape {strange[0]}; it has {', '.join(known) or 'none'}"
        )
    if _had(suspect, assumed):
        raise ModelError(f"the model has {suspect} already")
    if not _shapes(suspect, assumed, 1):
        why = effect.caution or "it is an event of one recording"
        raise ModelError(f"no motion shows {suspect}: {why}")
    return suspect


def _had(suspect: Suspect, assumed: Assumed) -> bool:
    """Return whether the model has an effect."""
    had = {(term.effect.name, term.joint) for term in assumed.base.basis.terms}
    return (suspect.effect, _joint(suspect, assumed)) in had


def _joint(suspect: Suspect, assumed: Assumed) -> int:
    return assumed.model.joints.index(suspect.joint)


def _shapes(suspect: Suspect, assumed: Assumed, most: int) -> list[Candidate]:
    """Return an effect in at most this many shapes."""
    return spread(_every_shape(suspect, assumed), most)


def _seen_shapes(suspect: Suspect, assumed: Assumed, most: int) -> list[Candidate]:
    """Return an effect in at most this many shapes, of those that show above creeping speed."""
    every = _every_shape(suspect, assumed)
    more = [one for one in every if not creeps(one, assumed.base.x)]
    return spread(more or every, most)


def _every_shape(suspect: Suspect, assumed: Assumed) -> list[Candidate]:
    """Return an effect in all shapes tried; none if the model has it or no motion shows it."""
    effect, joint = suspect.known, _joint(suspect, assumed)
    if not shown_by_motion(effect) or _had(suspect, assumed):
        return []
    shapes: Sequence[Mapping[str, float]] = effect.candidates(assumed.base.x, joint)
    every = [Candidate(effect, joint, {**shape, **suspect.shape}) for shape in shapes]
    return list({tuple(sorted(one.shape.items())): one for one in every}.values())
