"""Learning as the paper does: (42) with the friction kernel (51), and σ, σ_f and γ by folds.

Regularised least squares (42) with K_fri beside K_dyn is relaxed by ρ as in (43). With the Gram
matrix of (43) times 1 − ρ, and a the coefficients over 1 − ρ,

    (K_dyn + w K_fri + (1 − ρ) γ M) a = y,      f = Σ K_dyn a + Φ b,      b = w Σ Φᵀ a,

where w = (1 − ρ) / ρ: the solution (45), (46), without a copy of K_dyn. Cross-validation chooses
the numbers, as in section IV-A.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.identification.problem import rows_of
from lagrangian_ff.identification.samples import evenly, groups
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError, with_least_noise
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.identification.spec import Spec
from lagrangian_ff.kernels import Kernel, States
from lagrangian_ff.kernels.base import largest
from lagrangian_ff.kernels.dense import gram_of, together

Joints = tuple[int, ...]

RHO = 1e-3
"""ρ is this times trace(K_dyn) / trace(K_fri), as in section IV-A."""
STAGES = ((0.25, 0.55), (0.5, 0.3), (1.0, 0.15))
"""Share of the samples, and of the evaluations, of each stage of a search."""
EVALUATIONS = 20
"""Of each number, over all stages."""
CLOSER = 0.4
"""The first steps of a stage over those of the stage before."""
FAILED = 1e12
"""Cost where there is no factor."""


@dataclass(frozen=True)
class Setting:
    """The kernel and the numbers that are chosen before (42) is solved.

    Attributes:
        kernel: K_dyn.
        gamma: (N,) γ of each joint.
        sigma_f: (N,) rad/s, of (51); None leaves K_fri out.
    """

    kernel: Kernel
    gamma: Floats
    sigma_f: Floats | None


@dataclass(frozen=True)
class Solved:
    """The solution for joints that are solved together.

    Attributes:
        joints: their indices.
        system: the factored equations.
        rho: of (43); 0 without K_fri.
        raised: the factor by which γ was raised until there was a Cholesky factor.
    """

    joints: Joints
    system: System
    rho: float
    raised: float

    def left_out(self, folds: list[Ints]) -> Floats:
        """Return torques minus what a fit without their fold predicts, (M n,) fold by fold."""
        rows = [rows_of(fold, len(self.joints)) for fold in folds]
        return np.concatenate([left.residual for left in self.system.left_out(rows)])


def solve(setting: Setting, x: States, tau: Floats, joints: Joints) -> Solved:
    """Solve (42) for the joints that are solved together.

    Args:
        setting: of all joints.
        x, tau: (M, N) states and torques.
        joints: a group that `kernels.dense.together` returns.

    Raises:
        NotPositiveDefiniteError: even with much more regularisation there is no factor, or ρ is no
            number below 1.
    """

    def attempt(raised: float) -> Solved:
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

    return with_least_noise(attempt)[0]


def friction_columns(x: States, training: States, sigma_f: Floats) -> Floats:
    """Return the basis Φ (M, N, 3) of (51), joint by joint.

    Args:
        x: (M, N) states.
        training: whose largest velocity is 1 in (51), as in section IV.
        sigma_f: (N,) rad/s.
    """
    viscous = x.qd / largest(training.qd)
    return np.stack([viscous, np.tanh(x.qd / sigma_f), np.ones_like(x.qd)], axis=2)


@dataclass(frozen=True)
class Relaxed:
    """Torques (45) that were learned.

    Attributes:
        setting: they were learned with.
        x: (M, N) training states.
        parts: the solutions of all joints.
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
        """Return predicted torques (V, N), in the unit of those learned from."""
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
        """Learn without K_fri, from torques tau (M, N) that have no friction."""
        return Relaxed.learned(replace(self.setting, sigma_f=None), self.x, tau)

    def record(self) -> dict[str, object]:
        """Return the numbers it was learned with, as JSON holds them."""
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
    """Return a number common to all joints, or a list with one for each."""
    if np.all(values == values[0]):
        return float(values[0])
    return [float(value) for value in values]


@dataclass(frozen=True)
class Axis:
    """A positive number that is searched on its logarithm.

    Attributes:
        name: of the number.
        start, low, high: where the search begins, and its bounds.
        step: of the logarithm, the first one.
    """

    name: str
    start: float
    low: float
    high: float
    step: float


GAMMA = Axis("gamma", 1e-4, 1e-12, 1.0, 2.0)
SIGMA_F = Axis("sigma_f", 0.05, 1e-3, 3.0, 1.2)
SIGMA_STEP = 1.2


def learn_as_paper(spec: Spec, x: States, tau: Floats, fold: Ints, gamma: float | None) -> Relaxed:
    """Learn with the paper's kernels.

    A kernel with hyperparameters for each joint chooses them joint by joint, as in (35).

    Args:
        spec: a kernel, and K_fri (51) if it has effects.
        x, tau: (M, N) states and torques.
        fold: (M,) in which each sample is left out.
        gamma: γ of (42), raised tenfold until there is a factor; None chooses it.

    Raises:
        NotPositiveDefiniteError: there is no factor however much it is raised.
    """
    every = np.ones(x.joints)
    setting = Setting(
        spec.kernel.start(x),
        every * (GAMMA.start if gamma is None else gamma),
        every * SIGMA_F.start if spec.effects else None,
    )
    # The scales of rates stay what the paper makes them.
    axes = [
        Axis(one.name, value, one.low * value, one.high * value, SIGMA_STEP)
        for one in spec.kernel.searched
        if one.name == "sigma"
        for value in [float(setting.kernel.hyperparameters[one.name][0])]
    ]
    axes += [GAMMA] if gamma is None else []
    axes += [SIGMA_F] if spec.effects else []
    apart = spec.kernel.per_joint
    every_joint = range(x.joints)
    for joints in [(joint,) for joint in every_joint] if apart else [tuple(every_joint)]:
        search = _Search(x, tau, fold, joints, setting, axes)
        setting = search.at(least(search.error, axes))
    return Relaxed.learned(setting, x, tau)


def least(cost: Callable[[Floats, float], float], axes: Sequence[Axis]) -> Floats:
    """Return the numbers with the least cost that a simplex search finds (Nelder and Mead).

    The search begins on few samples and ends on all.

    Args:
        cost: of some numbers (A,), on a share of the samples.
        axes: the A numbers; with none there is no search.
    """
    point = np.log([axis.start for axis in axes])
    if not axes:
        return point
    bounds = np.log([(axis.low, axis.high) for axis in axes])
    step = np.array([axis.step for axis in axes])
    for samples, share in STAGES:
        corners = np.clip([point, *(point + np.diag(step))], *bounds.T)

        def of(values: Floats, samples: float = samples) -> float:
            return cost(np.exp(values), samples)

        most = max(round(share * EVALUATIONS * len(axes)), len(axes) + 2)
        options = {"initial_simplex": corners, "maxfev": most, "xatol": 0.03, "fatol": 1e-3}
        found = minimize(of, point, method="Nelder-Mead", bounds=bounds, options=options)
        point, step = np.asarray(found.x), CLOSER * step
    return np.exp(point)


@dataclass(frozen=True)
class _Search:
    """The numbers of some joints, and the error of samples left out that they give.

    Attributes:
        x, tau, fold: of all joints.
        joints: whose numbers are searched.
        setting: of the other joints.
        axes: the numbers.
    """

    x: States
    tau: Floats
    fold: Ints
    joints: Joints
    setting: Setting
    axes: Sequence[Axis]

    def at(self, values: Floats) -> Setting:
        """Return the setting with these numbers."""
        setting = self.setting
        for axis, value in zip(self.axes, values, strict=True):
            if axis.name == "gamma":
                setting = replace(setting, gamma=self._with(setting.gamma, value))
            elif axis.name == "sigma_f":
                assert setting.sigma_f is not None
                setting = replace(setting, sigma_f=self._with(setting.sigma_f, value))
            else:
                held = setting.kernel.hyperparameters[axis.name]
                kernel = setting.kernel.replace(**{axis.name: self._with(held, value)})
                setting = replace(setting, kernel=kernel)
        return setting

    def _with(self, held: Floats, value: float) -> Floats:
        if len(self.joints) == self.x.joints:
            return np.full_like(held, value)
        out = np.array(np.broadcast_to(held, (self.x.joints,)))
        out[list(self.joints)] = value
        return out

    def error(self, values: Floats, share: float) -> float:
        """Return the logarithm of the mean squared torque that is left of samples left out."""
        index = evenly(len(self.x), round(share * len(self.x)))
        x, tau, folds = self.x.take(index), self.tau[index], groups(self.fold[index])
        setting = self.at(values)
        try:
            left = [
                solve(setting, x, tau, joints).left_out(folds)
                for joints in together(setting.kernel, x.joints)
                if joints[0] in self.joints
            ]
        except (NotPositiveDefiniteError, np.linalg.LinAlgError):
            return FAILED
        squared = float(np.mean(np.concatenate(left) ** 2))
        return float(np.log(squared)) if squared > 0.0 else FAILED
