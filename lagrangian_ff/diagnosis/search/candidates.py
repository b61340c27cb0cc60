"""What may be missing: every effect of the catalogue on every joint, at every shape tried."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.search.unnamed import UNNAMED, Unnamed
from lagrangian_ff.effects import EFFECTS, Effect, Inputs
from lagrangian_ff.identification.basis import Basis, Term

Floats = NDArray[np.float64]


HIDDEN_BY_DESIGN = frozenset(
    {"torque_gain", "rotor_inertia", "asymmetric_coulomb", "eccentricity", "payload"}
)
"""No motion of the arm alone shows the first four over a free rigid-body part and free friction;
a payload is asked for on all joints at once, see `change`."""


@dataclass(frozen=True)
class Candidate:
    """An effect with its shape, or a dependence without a name, on one joint.

    Attributes:
        source: what it is.
        joint: whose torque it adds to.
        shape: its nonlinear parameters.
    """

    source: Effect | Unnamed
    joint: int
    shape: Mapping[str, float] = field(default_factory=dict)

    @property
    def named(self) -> bool:
        """Whether it is an effect of the catalogue."""
        return isinstance(self.source, Effect)

    @property
    def effect(self) -> Effect:
        """The effect, where it is one."""
        assert isinstance(self.source, Effect)
        return self.source

    @property
    def key(self) -> tuple[str, int]:
        """Name and joint: candidates that share it differ in shape only."""
        return self.source.name, self.joint

    @property
    def cause(self) -> tuple[str, int]:
        """Name, and the joint whose hardware it is: one cause may be felt on several joints."""
        of = self.effect.cause(self.joint, self.shape) if self.named else self.joint
        return self.source.name, of

    def term(self) -> Term:
        """The candidate as a term of a model."""
        return Term(self.effect, self.joint, dict(self.shape))

    def columns(self, x: Inputs) -> Floats:
        """(S, P) its columns at the samples of x."""
        if isinstance(self.source, Effect):
            return self.term().columns(x)
        if x.whole is not None and x.window > 1:
            return x.mean(self.source.columns(x.whole, self.joint))
        return self.source.columns(x, self.joint)


def named(
    x: Inputs, basis: Basis, joints: Iterable[int], effects: Mapping[str, Effect] | None = None
) -> list[Candidate]:
    """All effects that the model does not have on a joint, at all shapes that are tried first."""
    present = {(term.effect.name, term.joint) for term in basis.terms}
    return [
        Candidate(effect, joint, shape)
        for joint in joints
        for effect in (effects or EFFECTS).values()
        if (effect.name, joint) not in present and effect.name not in HIDDEN_BY_DESIGN
        for shape in effect.candidates(x, joint)
    ]


def unnamed(x: Inputs, joints: Iterable[int]) -> list[Candidate]:
    """Dependences of any form on one coordinate: what a known effect must do better than."""
    return [
        Candidate(dependence, joint)
        for joint in joints
        for make in UNNAMED
        for dependence in make(x, joint)
    ]
