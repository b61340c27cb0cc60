"""Learning torques with a model, in the way that suits its kernel."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.errors import UserError
from lagrangian_ff.identification.spec import FRICTION, Spec, parse
from lagrangian_ff.kernels import KERNELS, DifferentiableKernel, States
from lagrangian_ff.studies.regression.ours import learn_by_evidence
from lagrangian_ff.studies.regression.paper import learn_as_paper

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Learned(Protocol):
    """Torques that were learned."""

    def torque(self, x: States) -> Floats:
        """(V, N) predicted, in the unit of those learned from."""

    def without_friction(self, tau: Floats) -> "Learned":
        """The same numbers without `fri`, learned from torques tau (M, N) without friction."""

    def record(self) -> dict[str, object]:
        """The numbers it was learned with, γ and what it was raised by, as JSON holds them."""


def model_of(text: str) -> Spec:
    """The kernel of a name, alone or with `fri`.

    Raises:
        UserError: there is no such model, or it is none of these; says what there is.
    """
    spec = parse(text)
    names = {effect.name for effect in spec.effects}
    if (
        len(spec.alternatives) > 1
        or spec.further
        or names not in (set(), set(FRICTION))
        or spec.kernel.name == "none"
    ):
        known = ", ".join(name for name in KERNELS if name != "none")
        raise UserError(
            f"model '{text}': expected one kernel ({known}), alone or with fri as in vrbfs+fri"
        )
    return spec


def asked(models: Sequence[str], usual: Sequence[str]) -> tuple[str, ...]:
    """The models that are asked for; the usual ones where none is.

    Raises:
        UserError: there is no such model; see `model_of`.
    """
    for model in models:
        model_of(model)
    return tuple(models or usual)


def learn(spec: Spec, x: States, tau: Floats, fold: Ints, gamma: float | None) -> Learned:
    """Learn the torques of independent samples.

    Args:
        spec: see `model_of`.  x: (M, N) states.  tau: (M, N) torques.
        fold: (M,) of cross-validation.
        gamma: γ of (42); None chooses it.

    Raises:
        ModelError, NotPositiveDefiniteError: no Gram matrix has a factor.
    """
    by_evidence = issubclass(spec.kernel, DifferentiableKernel)
    return (learn_by_evidence if by_evidence else learn_as_paper)(spec, x, tau, fold, gamma)
