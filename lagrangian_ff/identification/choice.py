"""What of a model is chosen before it is solved: its hyperparameters, and its units of torque."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.spec import Spec
from lagrangian_ff.kernels import CoupledKernel, Kernel, States

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Choice:
    """Everything about a model that is not linear in the torques.

    Attributes:
        kernel: with its hyperparameters.
        noise: (N,) variance of each normalised torque, γ M of (42) in the kernel's units.
        shapes: for each effect that has them, (N,) of each shape parameter.
    """

    kernel: Kernel
    noise: Floats
    shapes: Mapping[str, Mapping[str, Floats]]

    def basis(self, spec: Spec, joints: int) -> Basis:
        """Every effect of the model on every joint, joint by joint."""
        return Basis(
            tuple(
                Term(
                    effect,
                    joint,
                    {name: float(v[joint]) for name, v in self.shapes.get(effect.name, {}).items()},
                )
                for joint in range(joints)
                for effect in spec.effects
            )
        )

    def shaped_as(self, basis: Basis) -> "Choice":
        """The same with the shapes of a basis' terms."""
        shapes = {
            effect: {name: values.copy() for name, values in named.items()}
            for effect, named in self.shapes.items()
        }
        for term in basis.terms:
            for name, value in term.shape.items():
                shapes[term.effect.name][name][term.joint] = value
        return replace(self, shapes=shapes)


@dataclass(frozen=True)
class Scaling:
    """How torques are normalised before the kernel sees them.

    Attributes:
        unit: (N,) N·m that count as one; undone on the way out.
        noise: (N,) relative standard deviation of the noise between joints, in those units.
    """

    unit: Floats
    noise: Floats

    @classmethod
    def of(cls, tau: Floats, per_joint: bool = True, trust: Floats | None = None) -> "Scaling":
        """Per joint, each torque is divided by its own spread; else all by the largest.

        With one unit for all joints the predicted torques still derive from one Lagrangian, and
        the noise is taken in proportion to each joint's spread instead. Torques tau (M, N) count
        as much as they are trusted, (M, N).
        """
        middle = np.average(tau, axis=0, weights=trust)
        spread = np.sqrt(np.average((tau - middle) ** 2, axis=0, weights=trust))
        largest = spread.max(initial=0.0) or 1.0
        spread = np.where(spread > 1e-9 * largest, spread, largest)
        if per_joint:
            return cls(spread, np.ones_like(spread))
        return cls(np.full_like(spread, largest), spread / largest)

    @property
    def spread(self) -> Floats:
        """(N,) N·m, the spread of each joint's torque."""
        return self.unit * self.noise


def with_noise(choice: Choice, relative: Floats, states: States) -> Choice:
    """The choice with its noise set relative to the kernel's mean prior variance.

    Args:
        relative: (N,) or (1,) ratio of noise variance to prior variance.
        states: (M, N) where the prior variance is taken.
    """
    prior = choice.kernel.variance(states).mean(axis=0)
    if isinstance(choice.kernel, CoupledKernel):
        prior = np.full_like(prior, prior.mean())
    prior = np.where(prior > 0.0, prior, 1.0)
    return replace(choice, noise=np.broadcast_to(relative, prior.shape) * prior)
