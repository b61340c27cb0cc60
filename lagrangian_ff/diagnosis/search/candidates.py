"""The candidates: every effect of the catalogue, and every curve, on every joint."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.search.nonparametric import ALTERNATIVES, Alternative
from lagrangian_ff.effects import EFFECTS, Curve, Effect, Inputs
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.recording.motion import WITHOUT_FRICTION

HELD = 0.9
"""Share of a candidate's squares from which on a curve has it."""


@dataclass(frozen=True)
class Candidate:
    """An effect with its shape, or a nonparametric alternative, on one joint.

    Attributes:
        source: the effect or alternative.
        joint: the joint whose torque it adds to.
        shape: its nonlinear parameters.
    """

    source: Effect | Alternative
    joint: int
    shape: Mapping[str, float] = field(default_factory=dict)

    @property
    def named(self) -> bool:
        """Return whether it is an effect of the catalogue."""
        return isinstance(self.source, Effect)

    @property
    def effect(self) -> Effect:
        """Return the effect; the candidate must be `named`."""
        assert isinstance(self.source, Effect)
        return self.source

    @property
    def key(self) -> tuple[str, int]:
        """Return name and joint: candidates that share them differ in shape only."""
        return self.source.name, self.joint

    @property
    def cause(self) -> tuple[str, int]:
        """Return the name and the joint whose hardware it is; several joints may feel one cause."""
        of = self.effect.cause(self.joint, self.shape) if self.named else self.joint
        return self.source.name, of

    @property
    def others(self) -> Mapping[int, float]:
        """Return the other joints that it acts on, with the factor of its columns on each."""
        return self.term().others if self.named else {}

    def term(self) -> Term:
        """Return the candidate as a term of a model."""
        return Term(self.effect, self.joint, dict(self.shape))

    def columns(self, x: Inputs) -> Floats:
        """Return its columns (S, P) at the samples of x."""
        if isinstance(self.source, Effect):
            return self.term().columns(x)
        if x.whole is not None and x.window > 1:
            return x.mean(self.source.columns(x.whole, self.joint))
        return self.source.columns(x, self.joint)


def named(
    x: Inputs, basis: Basis, joints: Iterable[int], effects: Mapping[str, Effect] | None = None
) -> list[Candidate]:
    """Return all effects that the model lacks on a joint, at all shapes of the first search.

    A lasting event is searched on all joints at once, see `change`.
    """
    present = {(term.effect.name, term.joint) for term in basis.terms}
    return [
        Candidate(effect, joint, shape)
        for joint in joints
        for effect in (effects or EFFECTS).values()
        if (effect.name, joint) not in present
        and effect.observable
        and effect.arm_event != "lasting"
        for shape in effect.candidates(x, joint)
    ]


def searched_for(effort: str, basis: Basis) -> Mapping[str, Effect] | None:
    """Return the effects that may be missing; None is the whole catalogue.

    Where the drive compensates friction, only plain friction shows whether some is left over; its
    other forms are searched once the model has that.

    Args:
        effort: what the recorded effort holds.  basis: the effects of the model.
    """
    if effort != WITHOUT_FRICTION or any(term.effect.plain for term in basis.terms):
        return None
    every = EFFECTS.items()
    return {name: one for name, one in every if one.plain or one.kind != "friction"}


def not_held(candidates: Sequence[Candidate], x: Inputs, basis: Basis) -> list[Candidate]:
    """Return the candidates that no curve of their joint in a basis already holds.

    What is over the same coordinates as a curve is left of it at the most.
    """
    left = list(candidates)
    for term in basis.terms:
        if not isinstance(term.effect, Curve):
            continue
        span, _ = np.linalg.qr(Term(term.effect.whole(), term.joint).columns(x))
        left = [c for c in left if c.joint != term.joint or not held(c.columns(x), span)]
    return left


def held(columns: Floats, span: Floats) -> bool:
    """Return whether orthonormal columns (S, C) span most of the squares of others (S, P)."""
    outside = columns - span @ (span.T @ columns)
    return float(np.sum(outside**2)) < (1.0 - HELD) * float(np.sum(columns**2))


def nonparametric(x: Inputs, joints: Iterable[int]) -> list[Candidate]:
    """Return curves over one or two coordinates, which an effect must beat to be named."""
    return [
        Candidate(alternative, joint)
        for joint in joints
        for make in ALTERNATIVES
        for alternative in make(x, joint)
    ]


def bends_over_speed(effect: Effect) -> bool:
    """Return whether an effect is friction over speed that is not plain: a bump, or a bend."""
    over_speed = effect.kind == "friction" and effect.coordinate == "velocity"
    return over_speed and not effect.remembers and not effect.plain


def at_end(x: Inputs, candidate: Candidate) -> str:
    """Return which shape ends where nature ends it; empty if none does.

    The data then ask for what this effect cannot be, and another one may be meant.
    """
    shapes, found = candidate.effect.shapes, candidate.shape
    of = [shape.name for shape in shapes if shape.joint]
    every = candidate.effect.candidates(x, candidate.joint)
    tried = [one for one in every if all(one.get(name) == found.get(name) for name in of)]
    for shape in shapes:
        values = {one[shape.name] for one in tried if shape.bounds and shape.name in one}
        value = found.get(shape.name, 0.0)
        inside = len(values) < 3 or 1.001 * min(values) < value < 0.999 * max(values)
        if not inside:
            unit = "" if shape.unit == "1" else f" {shape.unit}"
            return (
                f"its {shape.name} ({shape.meaning}) is {value:.3g}{unit}, an end of what is "
                "possible: the data may mean another effect"
            )
    return ""
