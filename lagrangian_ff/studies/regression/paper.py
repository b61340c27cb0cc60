"""Learning as the paper does: σ, σ_f and γ by cross-validation, section IV-A."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification.samples import evenly, groups
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.identification.spec import Spec
from lagrangian_ff.kernels import IndependentKernel, Kernel, States
from lagrangian_ff.kernels.dense import together
from lagrangian_ff.studies.regression.relaxed import Joints, Relaxed, Setting, solve
from lagrangian_ff.studies.regression.search import Axis, least

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

GAMMA = Axis("gamma", 1e-4, 1e-12, 1.0, 2.0)
SIGMA_F = Axis("sigma_f", 0.05, 1e-3, 3.0, 1.2)
SIGMA_STEP = 1.2
FAILED = 1e12


def learn_as_paper(spec: Spec, x: States, tau: Floats, fold: Ints, gamma: float | None) -> Relaxed:
    """Learn with the paper's kernels.

    Joints with hyperparameters of their own choose them apart, as in (35); others together.

    Args:
        spec: a kernel, and K_fri (51) where it has effects.
        x: (M, N) states.  tau: (M, N) torques.
        fold: (M,) in which each sample is left out.
        gamma: γ of (42), raised tenfold as often as it takes to factor; None chooses it.

    Raises:
        NotPositiveDefiniteError: there is no factor however much it is raised.
    """
    every = np.ones(x.joints)
    axes = [*_kernel_axes(spec.kernel, x)]
    setting = Setting(
        spec.kernel.start(x),
        every * (GAMMA.start if gamma is None else gamma),
        every * SIGMA_F.start if spec.effects else None,
    )
    axes += [GAMMA] if gamma is None else []
    axes += [SIGMA_F] if spec.effects else []
    for joints in _choosing_together(spec.kernel, x.joints):
        search = _Search(x, tau, fold, joints, setting, axes)
        setting = search.at(least(search.error, axes))
    return Relaxed.learned(setting, x, tau)


def _kernel_axes(kernel: type[Kernel], x: States) -> list[Axis]:
    """σ, where the kernel has one; the scales of rates stay what the paper makes them."""
    start = kernel.start(x).hyperparameters
    return [
        Axis(one.name, value, one.low * value, one.high * value, SIGMA_STEP)
        for one in kernel.searched
        if one.name == "sigma"
        for value in [float(start[one.name][0])]
    ]


def _choosing_together(kernel: type[Kernel], joints: int) -> list[Joints]:
    """Which joints share their hyperparameters."""
    if issubclass(kernel, IndependentKernel) and kernel.per_joint:
        return [(joint,) for joint in range(joints)]
    return [tuple(range(joints))]


@dataclass(frozen=True)
class _Search:
    """The numbers of some joints, and the error of samples left out that they come to.

    Attributes:
        x, tau, fold: of all joints.  joints: whose numbers are searched.
        setting: what the other joints have.  axes: the numbers.
    """

    x: States
    tau: Floats
    fold: Ints
    joints: Joints
    setting: Setting
    axes: Sequence[Axis]

    def at(self, values: Floats) -> Setting:
        """The setting with these numbers."""
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
        """Logarithm of the mean squared torque that is left of samples left out."""
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
