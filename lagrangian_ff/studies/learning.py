"""Learning torques from independent samples, as the paper does or as this package does."""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import UserError
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.choosing.choose import choose
from lagrangian_ff.identification.findings import hyperparameters_of
from lagrangian_ff.identification.problem import Problem, Scaling
from lagrangian_ff.identification.records import number_or_list
from lagrangian_ff.identification.samples import Samples
from lagrangian_ff.identification.settings import Settings
from lagrangian_ff.identification.solving.posterior import Posterior, exact
from lagrangian_ff.identification.solving.solution import with_least_noise
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.identification.spec import FRICTION, Spec, parse
from lagrangian_ff.kernels import KERNELS, States
from lagrangian_ff.studies.paper import learn_as_paper, plain


class Learned(Protocol):
    """Torques that were learned."""

    def torque(self, x: States) -> Floats:
        """Return predicted torques (V, N), in the unit of those learned from."""

    def without_friction(self, tau: Floats) -> "Learned":
        """Learn with the same numbers without `fri`, from torques tau (M, N) without friction."""

    def record(self) -> dict[str, object]:
        """Return the numbers it was learned with, γ and its factor, as JSON holds them."""


def model_of(text: str) -> Spec:
    """Return the kernel of a name, alone or with `fri`.

    Raises:
        UserError: there is no such model, or the studies do not take it.
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


def learn(spec: Spec, x: States, tau: Floats, fold: Ints, gamma: float | None) -> Learned:
    """Learn the torques of independent samples, in the way that suits the kernel.

    Args and errors are those of `learn_as_paper`; the model is one that `model_of` returns.
    """
    by_evidence = bool(spec.kernel.differentiable)
    return (_learn_by_evidence if by_evidence else learn_as_paper)(spec, x, tau, fold, gamma)


@dataclass(frozen=True)
class Exact(Learned):
    """Torques by (44) that were learned.

    Attributes:
        posterior: with its samples and hyperparameters.
        raised: the factor by which the noise was raised until there was a Cholesky factor.
    """

    posterior: Posterior[System]
    raised: float

    @classmethod
    def learned(cls, problem: Problem) -> "Exact":
        """Learn the torques of a problem.

        Raises:
            NotPositiveDefiniteError: even with much more noise there is no factor.
        """
        return cls(*with_least_noise(lambda raised: exact(problem.noisier(raised))))

    def torque(self, x: States) -> Floats:
        return self.posterior.torque(Inputs.of(x))

    def without_friction(self, tau: Floats) -> "Exact":
        problem = self.posterior.problem
        samples = replace(problem.samples, tau=tau)
        return Exact.learned(problem.of(samples).having(basis=Basis(())))

    def record(self) -> dict[str, object]:
        problem = self.posterior.problem
        found = hyperparameters_of(problem)
        held = {name: number_or_list(v) for name, v in found.items() if name != "gamma"}
        gamma = problem.noise / (self.raised * len(problem.samples))
        return {"hyperparameters": held, "gamma": plain(gamma), "gamma_raised": self.raised}


def _learn_by_evidence(
    spec: Spec, x: States, tau: Floats, fold: Ints, gamma: float | None
) -> Exact:
    """Learn as identification does: the evidence chooses hyperparameters, and (44) is solved."""
    samples, unscaled = Samples(Inputs.of(x), tau, fold), Scaling(*np.ones((2, x.joints)))
    problem = choose(spec, samples, [unscaled], Settings(selection="evidence")).problem
    if gamma is not None:
        problem = problem.having(noise=np.full(x.joints, gamma * len(x)))
    return Exact.learned(problem)
