"""The kernel of a robot whose bodies are known, if not exactly.

With Y the regressor of the bodies' inertial parameters π (see `tree`), π0 as the CAD has them, and

    τ = Y (α π0 + δ) + ρ qdd + ...,        α ~ N(0, 1), δ ~ N(0, d² S), ρ_n ~ N(0, r_n²),

the torques have the kernel

    K = β (τ0 τ0ᵀ + d² Y S Yᵀ + r r ᵀ qdd qddᵀ) + c K',        τ0 = Y π0.

S is diagonal: a mass varies by its own size, a first moment and an inertia by that mass times the
body's size once and twice. ρ are the rotors behind their gears, which a URDF does not have. K' is a
kernel on the Lagrangian: it corrects. So the CAD is a mean whose weight the torques decide, and
wrong masses are as good as other ones.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels.base import (
    CHUNK_ENTRIES,
    Contracted,
    CoupledKernel,
    DifferentiableKernel,
    Hyperparameter,
    Kernel,
    LagrangianKernel,
    Learned,
    largest,
)
from lagrangian_ff.kernels.dense import dense_cross, dense_gram
from lagrangian_ff.kernels.states import States

if TYPE_CHECKING:
    from lagrangian_ff.kernels.rigid.robot import Robot

Floats = NDArray[np.float64]
Self = TypeVar("Self", bound="Known")

CORRECTION = Hyperparameter(
    "correction", "1", "c: how much the kernel corrects the known bodies", 1e-4, 1e3
)
NUMBERS = (
    Hyperparameter("bodies", "1/(N·m)²", "β: weight of the torque of the URDF's masses", 1.0, 1.0),
    Hyperparameter("deviation", "1", "d: how far masses may be from the URDF's", 1.0, 1.0),
    Hyperparameter("armature", "kg·m²", "r: the inertia that rotors may have", 1.0, 1.0),
    CORRECTION,
)
"""What the numbers beside those of K' mean."""
DEVIATION_START = 0.3
CORRECTION_START = 1e-2
"""Prior variance of what corrects, in parts of that of the known bodies."""


@dataclass(frozen=True)
class Known(CoupledKernel):
    """Known bodies and what corrects them.

    Attributes:
        kernel: K', of the family.
        bodies: (1,) β, 1/(N·m)² in the kernel's units: weight of the CAD's own torque.
        deviation: (1,) d, how far from the CAD its parameters are, relative.
        armature: (N,) r, kg·m² that the rotors may have.
        correction: (1,) c.
    """

    kernel: Kernel
    bodies: Floats
    deviation: Floats
    armature: Floats
    correction: Floats

    mechanism: ClassVar["Robot"]
    family: ClassVar[type[Kernel]]

    @classmethod
    def start(cls: type[Self], x: States) -> Self:
        """The CAD's torque spreads by one, and each rotor's as much as its joint's."""
        kernel = cls.family.start(x)
        if "prismatic" in kernel.hyperparameters:
            kernel = kernel.replace(prismatic=cls.mechanism.prismatic)
        cad = cls.mechanism.tree.torque(x)
        spread = largest(np.std(cad, axis=0))
        moved = np.array([largest(x.qdd[:, n]) for n in range(x.joints)])
        own = np.sqrt(np.mean(cad**2, axis=0))
        variance = float(np.mean(kernel.variance(x)))
        return cls(
            kernel=kernel,
            bodies=np.array([spread**-2]),
            deviation=np.array([DEVIATION_START]),
            armature=np.where(own > 0.0, own, spread) / moved,
            correction=np.array([CORRECTION_START / variance if variance > 0.0 else 1.0]),
        )

    @property
    def hyperparameters(self) -> Mapping[str, Floats]:
        """See `Kernel.hyperparameters`; those of K' by their own names."""
        own = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "kernel"}
        return {**own, **self.kernel.hyperparameters}

    def replace(self: Self, **hyperparameters: Floats) -> Self:
        """See `Kernel.replace`."""
        mine = {f.name for f in fields(self)}
        own = {name: value for name, value in hyperparameters.items() if name in mine}
        rest = {name: value for name, value in hyperparameters.items() if name not in mine}
        return replace(self, kernel=self.kernel.replace(**rest), **own)

    def gram(self, x: States) -> Floats:
        """See `CoupledKernel.gram`."""
        known = self._features(x)
        with np.errstate(all="ignore"):  # what memory held above the diagonal is scaled, too
            out = dense_gram(self.kernel, x)
            out *= self.correction
        out += known @ known.T
        return out

    def cross(self, x: States, u: States) -> Floats:
        """See `CoupledKernel.cross`."""
        known = self._features(x) @ self._features(u).T
        return np.asarray(known + self.correction * dense_cross(self.kernel, x, u))

    def apply(self, x: States, u: States, a: Floats) -> Floats:
        """See `Kernel.apply`; in chunks, so that memory stays bounded."""
        return self.learned(u, a).torque(x)

    def learned(self, u: States, a: Floats) -> Learned:
        """See `Kernel.learned`: of the bodies no more than their parameters."""
        coefficients = self._features(u).T @ np.ravel(a)
        return _Bodies(self, self.kernel.learned(u, a), coefficients)

    def variance(self, x: States) -> Floats:
        """See `Kernel.variance`."""
        out = self.correction * self.kernel.variance(x)
        rows = max(1, CHUNK_ENTRIES // (x.joints * (10 * self.mechanism.tree.bodies + 1)))
        for first in range(0, len(x), rows):
            part = slice(first, first + rows)
            out[part] += np.sum(self._features(x.take(part)) ** 2, axis=1).reshape(-1, x.joints)
        return np.asarray(out)

    def inertial(self, u: States, a: Floats) -> Floats:
        """(B, 10) α π0 + δ, the parameters found, for coefficients a (M_u, N)."""
        tree = self.mechanism.tree
        rows = self._rows(u).T @ a.ravel()
        alpha = float(tree.inertial.ravel() @ rows)
        delta = self.deviation**2 * self.mechanism.scale.ravel() ** 2 * rows
        found = self.bodies * (alpha * tree.inertial.ravel() + delta)
        return np.asarray(found.reshape(-1, 10))

    def rotors(self, u: States, a: Floats) -> Floats:
        """(N,) kg·m² of the rotors found, for coefficients a (M_u, N)."""
        return np.asarray(self.bodies * self.armature**2 * np.sum(u.qdd * a, axis=0))

    def _features(self, x: States) -> Floats:
        """(M N, F) Z with Z Zᵀ = K − c K'."""
        rows = self._rows(x)
        cad = np.sqrt(self.bodies) * (rows @ self.mechanism.tree.inertial.ravel())[:, None]
        return np.hstack([cad, self._deviations(rows), self._rotors(x)])

    def _rows(self, x: States) -> Floats:
        """(M N, 10 B) the regressor, sample major."""
        return self.mechanism.tree.regressor(x).reshape(len(x) * x.joints, -1)

    def _deviations(self, rows: Floats) -> Floats:
        weight = np.sqrt(self.bodies) * self.deviation * self.mechanism.scale.ravel()
        return np.asarray(weight * rows)

    def _rotors(self, x: States) -> Floats:
        weighed = np.sqrt(self.bodies) * self.armature * x.qdd
        return np.asarray((weighed[:, :, None] * np.eye(x.joints)).reshape(-1, x.joints))


class KnownLagrangian(Known, LagrangianKernel):
    """Known bodies and a kernel that tells its Lagrangian."""

    def lagrangian(self, x: States, u: States, a: Floats) -> Floats:
        """See `LagrangianKernel.lagrangian`."""
        assert isinstance(self.kernel, LagrangianKernel)
        kinetic = 0.5 * np.sum(x.qd * self._momentum(x, u, a), axis=1)
        potential = self.mechanism.tree.potential(x.q) @ self.inertial(u, a).ravel()
        return kinetic - potential + self.correction * self.kernel.lagrangian(x, u, a)

    def momentum(self, x: States, u: States, a: Floats) -> Floats:
        """See `LagrangianKernel.momentum`."""
        assert isinstance(self.kernel, LagrangianKernel)
        return self._momentum(x, u, a) + self.correction * self.kernel.momentum(x, u, a)

    def _momentum(self, x: States, u: States, a: Floats) -> Floats:
        """(M, N) that of the bodies and their rotors."""
        bodies = self.mechanism.tree.momentum(x) @ self.inertial(u, a).ravel()
        return np.asarray(bodies + self.rotors(u, a) * x.qd)


@dataclass(frozen=True)
class _Bodies(Learned):
    """The torque of known bodies with learned parameters, and of what corrects them."""

    kernel: Known
    correction: Learned
    coefficients: Floats

    def torque(self, x: States) -> Floats:
        """See `Learned.torque`; in chunks, so that memory stays bounded."""
        torque = self.kernel.correction * self.correction.torque(x)
        rows = max(1, CHUNK_ENTRIES // (x.joints * len(self.coefficients)))
        for first in range(0, len(x), rows):
            part = slice(first, first + rows)
            features = self.kernel._features(x.take(part))
            torque[part] += (features @ self.coefficients).reshape(-1, x.joints)
        return np.asarray(torque)


class KnownDifferentiable(Known, DifferentiableKernel):
    """Known bodies and a kernel that climbs its evidence."""

    def contract(self, x: States, weights: Floats, vector: Floats) -> Mapping[str, Contracted]:
        """See `DifferentiableKernel.contract`."""
        assert isinstance(self.kernel, DifferentiableKernel)
        scale = float(self.correction[0])
        found = {
            name: Contracted(scale * one.total, scale * one.product)
            for name, one in self.kernel.contract(x, weights, vector).items()
        }
        lower = np.tril(weights)
        symmetric = lower + np.tril(lower, -1).T
        moved = self._deviations(self._rows(x))
        total = np.sum(moved * (symmetric @ moved))
        rate = 2.0 / self.deviation
        product = moved @ (moved.T @ vector)
        found["deviation"] = Contracted(rate * total, rate[:, None] * product)
        rotors = self._rotors(x)
        rates = 2.0 / self.armature
        totals = np.sum(rotors * (symmetric @ rotors), axis=0)
        products = rotors * (rotors.T @ vector)
        found["armature"] = Contracted(rates * totals, rates[:, None] * products.T)
        return found


def known(robot: "Robot", family: type[Kernel]) -> type[Kernel]:
    """The family of kernels of a robot that learn by another family what is not known of it."""
    words: dict[str, Any] = {
        "mechanism": robot,
        "family": family,
        "free": family.free,
        "name": family.name,
        "meaning": f"the bodies of {robot.name}, corrected by: {family.meaning}",
        "searched": (*family.searched, CORRECTION),
    }
    bases: list[type[Kernel]] = []
    if issubclass(family, LagrangianKernel):
        words["quadratic"] = family.quadratic
        bases.append(KnownLagrangian)
    if issubclass(family, DifferentiableKernel):
        words["differentiable"] = (*family.differentiable, "deviation", "armature")
        bases.append(KnownDifferentiable)
    return type(f"Known{family.__name__}", tuple(bases or [Known]), words)
