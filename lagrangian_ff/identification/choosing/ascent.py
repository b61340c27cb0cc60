"""Climbing the log evidence of a system by its gradient and its average information.

With A = G⁻¹Φ (Φᵀ G⁻¹ Φ)⁻¹, P as in `system`, a = P y and s² the amplitude, the restricted log
evidence E falls with the Gram matrix and the basis as

    −2 ∂E/∂G = P − a aᵀ / s²,        −∂E/∂Φ = A − a bᵀ / s².

Its curvature is taken as the average information ½ (G'_i a)ᵀ P (G'_j a) / s² of two numbers of the
Gram matrix, less what the amplitude takes, and (Φ'_i b)ᵀ P (Φ'_j b) / s² of two shapes (Gilmour,
Thompson and Cullis, Biometrics 51, 1995): it costs products with vectors only, and a dozen steps
arrive. A weak prior, see `belief`, holds what the torques say nothing about.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from lagrangian_ff.identification.choosing.belief import Belief
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.kernels import DifferentiableKernel, States

Floats = NDArray[np.float64]
Place = TypeVar("Place")

LONGEST = 1.5
"""The longest step of a logarithm."""
ENOUGH = 0.05
"""Nats that a step must bring for another to be tried, where nothing else is said."""
TRIALS = 8


@dataclass(frozen=True)
class Slopes:
    """How the log evidence changes with some logarithms.

    Attributes:
        slope: (K,) its derivative.
        information: (K, K) minus its second derivative, about.
    """

    slope: Floats
    information: Floats


@dataclass(frozen=True)
class Hill(Generic[Place]):
    """What is climbed, over logarithms (K,).

    Attributes:
        belief: of the logarithms, before any torque is seen.
        go: to a point; NotPositiveDefiniteError where nobody can stand.
        height: the log evidence there.  slopes: and how it changes.
        low, high: (K,) the ends of where it is climbed.
    """

    belief: Belief
    go: Callable[[Floats], Place]
    height: Callable[[Place], float]
    slopes: Callable[[Place], Slopes]
    low: Floats | float = -np.inf
    high: Floats | float = np.inf

    def climb(
        self,
        point: Floats,
        steps: int,
        told: Callable[[int], None] = lambda _: None,
        enough: float = ENOUGH,
        damping: float = 1.0,
    ) -> tuple[Floats, Place]:
        """Climb from a point.

        Args:
            point: where to begin.
            steps: at most.
            told: the number of each step.
            enough: nats that a step must bring for another to be tried.
            damping: of the first step; the farther the top may be, the more.

        Returns:
            The top, and what was found standing there.

        Raises:
            NotPositiveDefiniteError: nobody can stand at the first point.
        """
        place = self.go(point)
        height = self.height(place) + self.belief.height(point)
        for step in range(steps):
            told(step)
            before = height
            slopes = self.slopes(place)
            slope = slopes.slope + self.belief.slope(point)
            information = slopes.information + np.diag(self.belief.information(point))
            for _ in range(TRIALS):
                tried = np.clip(point + _step(slope, information, damping), self.low, self.high)
                try:
                    there = self.go(tried)
                    higher = self.height(there) + self.belief.height(tried)
                except (NotPositiveDefiniteError, np.linalg.LinAlgError):
                    higher = -np.inf
                if higher > height:
                    point, place, height = tried, there, higher
                    damping *= 0.2
                    break
                damping *= 8.0
            if height - before < enough:
                break
        return point, place


def _step(slope: Floats, information: Floats, damping: float) -> Floats:
    """Uphill: the slope over the information, damped, no number farther than `LONGEST`."""
    scale = damping * np.diag(np.diag(information))
    step = cho_solve(cho_factor(information + scale), slope)
    return np.asarray(np.clip(step, -LONGEST, LONGEST))


def numbers(kernel: DifferentiableKernel) -> dict[str, Floats]:
    """The kernel's numbers that the evidence is climbed in, by name."""
    return {name: kernel.hyperparameters[name] for name in kernel.differentiable}


def slopes_by_gram(
    system: System,
    kernel: DifferentiableKernel,
    states: States,
    noise: Floats,
    second: Floats | None = None,
    trust: Floats | None = None,
) -> Slopes:
    """By the logarithms of the kernel's numbers, in their order, and of the noise, joint by joint.

    Args:
        system: of all joints.  kernel, states: of its Gram matrix K.
        noise: (N,) variance of each joint's torque in it.
        second: (M N,) m of a Gram matrix K + K ∘ m mᵀ; without it, K alone.
        trust: (M, N) in each torque, whose noise is 1 / trust times as large; None trusts all.
    """
    by_gram = system.slope_by_gram()
    each = np.tile(noise, (len(states), 1)) / (1.0 if trust is None else trust)
    diagonal = (np.diag(by_gram).reshape(each.shape) * each).sum(axis=0)
    if second is not None:
        by_gram *= 1.0 + np.outer(second, second)
    found = kernel.contract(states, by_gram, system.weights)
    values = numbers(kernel)
    totals = [found[name].total * value for name, value in values.items()]
    products = [found[name].product * value[:, None] for name, value in values.items()]
    if second is not None:
        again = kernel.contract(states, by_gram, system.weights * second)
        for product, (name, value) in zip(products, values.items(), strict=True):
            product += again[name].product * value[:, None] * second
    own = np.tile(np.eye(len(noise)), len(states)) * each.ravel() * system.weights
    slope = -0.5 * np.concatenate([*totals, diagonal])
    moved = np.vstack([*products, own])
    white = projected(system, moved)
    shared = 0.5 * moved @ system.weights / system.amplitude
    information = 0.5 * (white.T @ white) / system.amplitude
    information -= np.outer(shared, shared) * 2.0 / system.degrees
    return Slopes(slope, information)


def projected(system: System, rows: Floats) -> Floats:
    """(n, K) W with Wᵀ W = rows P rowsᵀ, for rows (K, n)."""
    white = solve_triangular(system.upper, rows.T, trans=1, check_finite=False)
    fit = system.covariance @ (system.white_design.T @ white)
    return np.asarray(white - system.white_design @ fit)
