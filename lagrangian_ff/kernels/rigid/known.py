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
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, ClassVar

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.kernels import base
from lagrangian_ff.kernels.dense import dense_cross, dense_gram
from lagrangian_ff.kernels.rigid.tree import Tree
from lagrangian_ff.kernels.states import States

CORRECTION = base.Hyperparameter(
    "correction", "1", "c: how much the kernel corrects the known bodies", 1e-4, 1e3
)
NUMBERS = (
    base.Hyperparameter(
        "bodies", "1/(N·m)²", "β: weight of the torque of the URDF's masses", 1.0, 1.0
    ),
    base.Hyperparameter("deviation", "1", "d: how far masses may be from the URDF's", 1.0, 1.0),
    base.Hyperparameter("armature", "kg·m²", "r: the inertia that rotors may have", 1.0, 1.0),
    CORRECTION,
)
"""The hyperparameters beside those of K'."""
DEVIATION_START = 0.3
CORRECTION_START = 1e-2
"""Prior variance of the correction, relative to that of the known bodies."""


@dataclass(frozen=True)
class KnownFamily(base.MechanismFamily):
    """The kernels of a robot that learn by another family what is not known of it.

    Attributes:
        tree: the robot's bodies.
        prismatic: (N,) 1 where a coordinate slides, 0 where it turns.
    """

    tree: Tree
    prismatic: Floats

    def start(self, x: States) -> "Known":
        """Return the kernel whose CAD torque has variance 1, and each rotor's that of its joint."""
        kernel = self.inner.start(x)
        if "prismatic" in kernel.hyperparameters:
            kernel = kernel.replace(prismatic=self.prismatic)
        cad = self.tree.torque(x)
        spread = base.largest(np.std(cad, axis=0))
        moved = np.array([base.largest(x.qdd[:, n]) for n in range(x.joints)])
        own = np.sqrt(np.mean(cad**2, axis=0))
        variance = float(np.mean(kernel.variance(x)))
        made = {
            (False, False): Known,
            (True, False): KnownLagrangian,
            (False, True): KnownDifferentiable,
            (True, True): KnownMechanical,
        }[self.has_lagrangian, bool(self.inner.differentiable)]
        return made(
            self,
            kernel,
            bodies=np.array([spread**-2]),
            deviation=np.array([DEVIATION_START]),
            armature=np.where(own > 0.0, own, spread) / moved,
            correction=np.array([CORRECTION_START / variance if variance > 0.0 else 1.0]),
        )


@dataclass(frozen=True)
class Known(base.MechanismKernel):
    """The kernel of known bodies and of what corrects them, K'.

    Attributes:
        bodies: (1,) β, 1/(N·m)² in the kernel's units: weight of the CAD's own torque.
        deviation: (1,) d, how far from the CAD its parameters are, relative.
        armature: (N,) r, kg·m² that the rotors may have.
        correction: (1,) c.
    """

    of: KnownFamily
    bodies: Floats
    deviation: Floats
    armature: Floats
    correction: Floats

    def gram(self, x: States) -> Floats:
        known = self._features(x)
        with np.errstate(all="ignore"):  # memory above the diagonal is not initialised
            out = dense_gram(self.kernel, x)
            out *= self.correction
        out += known @ known.T
        return out

    def cross(self, x: States, u: States) -> Floats:
        known = self._features(x) @ self._features(u).T
        return np.asarray(known + self.correction * dense_cross(self.kernel, x, u))

    def apply(self, x: States, u: States, a: Floats) -> Floats:
        return self.learned(u, a).torque(x)

    def learned(self, u: States, a: Floats) -> base.Learned:
        coefficients = self._features(u).T @ np.ravel(a)
        return _Bodies(self, self.kernel.learned(u, a), coefficients)

    def variance(self, x: States) -> Floats:
        out = self.correction * self.kernel.variance(x)
        entries = x.joints * (10 * self.of.tree.bodies + 1)
        for part in base.chunks(len(x), base.CHUNK_ENTRIES // entries):
            out[part] += np.sum(self._features(x.take(part)) ** 2, axis=1).reshape(-1, x.joints)
        return np.asarray(out)

    def inertial(self, u: States, a: Floats) -> Floats:
        """Return (B, 10) the parameters found, α π0 + δ, for coefficients a (M_u, N)."""
        tree = self.of.tree
        rows = self._rows(u).T @ a.ravel()
        alpha = float(tree.inertial.ravel() @ rows)
        delta = self.deviation**2 * self.of.tree.scale.ravel() ** 2 * rows
        found = self.bodies * (alpha * tree.inertial.ravel() + delta)
        return np.asarray(found.reshape(-1, 10))

    def rotors(self, u: States, a: Floats) -> Floats:
        """Return (N,) kg·m² of the rotors found, for coefficients a (M_u, N)."""
        return np.asarray(self.bodies * self.armature**2 * np.sum(u.qdd * a, axis=0))

    def _features(self, x: States) -> Floats:
        """Return (M N, F) Z with Z Zᵀ = K − c K'."""
        rows = self._rows(x)
        cad = np.sqrt(self.bodies) * (rows @ self.of.tree.inertial.ravel())[:, None]
        return np.hstack([cad, self._deviations(rows), self._rotors(x)])

    def _rows(self, x: States) -> Floats:
        """Return (M N, 10 B) the regressor, sample major."""
        return self.of.tree.regressor(x).reshape(len(x) * x.joints, -1)

    def _deviations(self, rows: Floats) -> Floats:
        weight = np.sqrt(self.bodies) * self.deviation * self.of.tree.scale.ravel()
        return np.asarray(weight * rows)

    def _rotors(self, x: States) -> Floats:
        weighed = np.sqrt(self.bodies) * self.armature * x.qdd
        return np.asarray((weighed[:, :, None] * np.eye(x.joints)).reshape(-1, x.joints))


class KnownLagrangian(Known, base.LagrangianKernel):
    """Known bodies, corrected by a kernel that has a Lagrangian."""

    quadratic: ClassVar[Any] = property(attrgetter("kernel.quadratic"))

    @property
    def _inner(self) -> base.LagrangianKernel:
        assert isinstance(self.kernel, base.LagrangianKernel)
        return self.kernel

    def lagrangian(self, x: States, u: States, a: Floats) -> Floats:
        kinetic = 0.5 * np.sum(x.qd * self._momentum(x, u, a), axis=1)
        potential = self.of.tree.potential(x.q) @ self.inertial(u, a).ravel()
        return kinetic - potential + self.correction * self._inner.lagrangian(x, u, a)

    def momentum(self, x: States, u: States, a: Floats) -> Floats:
        return self._momentum(x, u, a) + self.correction * self._inner.momentum(x, u, a)

    def _momentum(self, x: States, u: States, a: Floats) -> Floats:
        """Return (M, N) the momentum of the bodies and their rotors."""
        bodies = self.of.tree.momentum(x) @ self.inertial(u, a).ravel()
        return np.asarray(bodies + self.rotors(u, a) * x.qd)


@dataclass(frozen=True)
class _Bodies(base.Learned):
    """The torque of known bodies with learned parameters, and of what corrects them."""

    kernel: Known
    correction: base.Learned
    coefficients: Floats

    def torque(self, x: States) -> Floats:
        torque = self.kernel.correction * self.correction.torque(x)
        entries = x.joints * len(self.coefficients)
        for part in base.chunks(len(x), base.CHUNK_ENTRIES // entries):
            features = self.kernel._features(x.take(part))
            torque[part] += (features @ self.coefficients).reshape(-1, x.joints)
        return np.asarray(torque)


class KnownDifferentiable(Known, base.DifferentiableKernel):
    """Known bodies, corrected by a kernel with derivatives by its hyperparameters."""

    def contract(self, x: States, weights: Floats, vector: Floats) -> Mapping[str, base.Contracted]:
        assert isinstance(self.kernel, base.DifferentiableKernel)
        scale = float(self.correction[0])
        found = {
            name: base.Contracted(scale * one.total, scale * one.product)
            for name, one in self.kernel.contract(x, weights, vector).items()
        }
        whole = base.symmetric(weights)
        moved = self._deviations(self._rows(x))
        total = np.sum(moved * (whole @ moved))
        rate = 2.0 / self.deviation
        product = moved @ (moved.T @ vector)
        found["deviation"] = base.Contracted(rate * total, rate[:, None] * product)
        rotors = self._rotors(x)
        rates = 2.0 / self.armature
        totals = np.sum(rotors * (whole @ rotors), axis=0)
        products = rotors * (rotors.T @ vector)
        found["armature"] = base.Contracted(rates * totals, rates[:, None] * products.T)
        return found


class KnownMechanical(KnownLagrangian, KnownDifferentiable):
    """Known bodies, corrected by a kernel with both."""
