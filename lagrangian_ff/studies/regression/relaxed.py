"""Regularised least squares (42) with the friction kernel (51) beside, relaxed by ρ as in (43).

With the Gram matrix of (43) times 1 − ρ, and a the coefficients over 1 − ρ,

    (K_dyn + w K_fri + (1 − ρ) γ M) a = y,      f = Σ K_dyn a + Φ b,      b = w Σ Φᵀ a,

where w = (1 − ρ) / ρ: the solution (45), (46), without a copy of K_dyn.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification.solving.rows import rows_of
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError, with_least_noise
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.kernels import Kernel, States
from lagrangian_ff.kernels.base import largest
from lagrangian_ff.kernels.dense import gram_of, together

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Joints = tuple[int, ...]

RHO = 1e-3
"""ρ is this times trace(K_dyn) / trace(K_fri), as in section IV-A."""


@dataclass(frozen=True)
class Setting:
    """All that is chosen before (42) is solved.

    Attributes:
        kernel: K_dyn.  gamma: (N,) γ of each joint.
        sigma_f: (N,) rad/s, of (51); None leaves K_fri out.
    """

    kernel: Kernel
    gamma: Floats
    sigma_f: Floats | None


@dataclass(frozen=True)
class Solved:
    """The joints that are solved together, solved.

    Attributes:
        joints: which.  system: the factored equations.
        rho: of (43); 0 without K_fri.
        raised: what γ was multiplied by, so that there was a Cholesky factor.
    """

    joints: Joints
    system: System
    rho: float
    raised: float

    def left_out(self, folds: list[Ints]) -> Floats:
        """(M n,) torques minus what a fit without their fold predicts, fold by fold."""
        rows = [rows_of(fold, len(self.joints)) for fold in folds]
        return np.concatenate([left.residual for left in self.system.left_out(rows)])


def solve(setting: Setting, x: States, tau: Floats, joints: Joints) -> Solved:
    """Solve (42) for the joints that are solved together.

    Args:
        setting: of all joints.  x: (M, N) states.  tau: (M, N) torques.
        joints: see `kernels.dense.together`.

    Raises:
        NotPositiveDefiniteError: even with much more regularisation there is no factor, or ρ is no
            number below 1.
    """
    return with_least_noise(lambda raised: _solve(setting, x, tau, joints, raised))[0]


def _solve(setting: Setting, x: States, tau: Floats, joints: Joints, raised: float) -> Solved:
    rows, width, rho = list(joints), len(joints), 0.0
    gram = gram_of(setting.kernel, x, joints)
    if setting.sigma_f is not None:
        columns = friction_columns(x, x, setting.sigma_f)[:, rows]
        rho = RHO * float(np.trace(gram)) / float(np.sum(columns**2))
        if not 0.0 < rho < 1.0:
            raise NotPositiveDefiniteError(f"rho is {rho:.3g}, expected between 0 and 1")
        with np.errstate(all="ignore"):  # what memory held above the diagonal
            for place in range(width):
                own = columns[:, place]
                gram[place::width, place::width] += (1.0 - rho) / rho * (own @ own.T)
    noise = np.tile(setting.gamma[rows], len(x)) * (raised * len(x) * (1.0 - rho))
    system = System.factor(gram, noise, np.empty((len(noise), 0)), tau[:, rows].ravel())
    return Solved(joints, system, rho, raised)


def friction_columns(x: States, training: States, sigma_f: Floats) -> Floats:
    """(M, N, 3) the basis Φ of (51), joint by joint.

    Args:
        x: (M, N) states.  training: whose largest velocity is 1 in (51), as in section IV.
        sigma_f: (N,) rad/s.
    """
    viscous = x.qd / largest(training.qd)
    return np.stack([viscous, np.tanh(x.qd / sigma_f), np.ones_like(x.qd)], axis=2)


@dataclass(frozen=True)
class Relaxed:
    """Torques (45) that were learned.

    Attributes:
        setting: they were learned with.  x: (M, N) training states.
        parts: the systems of all joints.
    """

    setting: Setting
    x: States
    parts: tuple[Solved, ...]

    @classmethod
    def learned(cls, setting: Setting, x: States, tau: Floats) -> "Relaxed":
        """Learn the torques tau (M, N) of states x (M, N); raises as `solve` does."""
        systems = together(setting.kernel, x.joints)
        return cls(setting, x, tuple(solve(setting, x, tau, joints) for joints in systems))

    def torque(self, x: States) -> Floats:
        """(V, N) predicted, in the unit of those learned from."""
        weights = np.empty_like(self.x.q)
        for part in self.parts:
            weights[:, list(part.joints)] = part.system.weights.reshape(len(self.x), -1)
        out = self.setting.kernel.learned(self.x, weights).torque(x)
        if self.setting.sigma_f is not None:
            shape = self.x, self.setting.sigma_f
            b = np.einsum("mnp,mn->np", friction_columns(self.x, *shape), weights)
            for part in self.parts:
                b[list(part.joints)] *= (1.0 - part.rho) / part.rho
            out = out + np.einsum("mnp,np->mn", friction_columns(x, *shape), b)
        return np.asarray(out)

    def without_friction(self, tau: Floats) -> "Relaxed":
        """The same without K_fri, learned from torques tau (M, N) that have no friction."""
        return Relaxed.learned(replace(self.setting, sigma_f=None), self.x, tau)

    def record(self) -> dict[str, object]:
        """The numbers it was learned with, as JSON holds them; see `regression.record`."""
        held: dict[str, Floats] = {**self.setting.kernel.hyperparameters}
        if self.setting.sigma_f is not None:
            held["sigma_f"] = self.setting.sigma_f
            held["rho"] = np.array([part.rho for part in self.parts])
        raised = max(part.raised for part in self.parts)
        return {
            "hyperparameters": {name: plain(values) for name, values in held.items()},
            "gamma": plain(self.setting.gamma),
            "gamma_raised": raised,
        }


def plain(values: Floats) -> object:
    """A number common to all joints, or a list with one for each."""
    if np.all(values == values[0]):
        return float(values[0])
    return [float(value) for value in values]
