"""More than torque: the Lagrangian that a model learned, energies, M, C, g, forward dynamics.

The torque of a Lagrangian is affine in acceleration, and where kinetic energy is quadratic in
velocity, the velocity's part of it is a quadratic form. Whatever the kernel, torques at a few
states then give exactly, nothing differentiated,

    M e_j = τ(q, qd, e_j) − τ(q, qd, 0),      g = τ(q, 0, 0),
    C e_j = ¼ (τ(q, qd + e_j, 0) − τ(q, qd − e_j, 0)),

the last by polarisation: the torque of the velocity is its form B(qd, qd), and B(qd, e_j) are the
Christoffel symbols of M times qd.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lagrangian_ff.effects import Inputs, checked_energies
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.mechanics.forward import acceleration, mass_of
from lagrangian_ff.identification.model import Model
from lagrangian_ff.kernels import LagrangianKernel, States

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Dynamics:
    """The rigid-body quantities of a model whose joints share one Lagrangian.

    Counted in are the kernel and the effects that keep energy (`Effect.energies`: rotors, springs,
    counterbalances, cogging). Friction and a constant torque are not; `forward` has all effects.
    A constant torque may hold a part of gravity that a limited range cannot tell from it.

    Kernels of the paper (`vrbf`, `vrbfs`) know nothing of a quadratic kinetic energy: their mass
    matrix ∂τ/∂qdd depends on velocity as well, and they have no Coriolis matrix.

    Every argument is (M, N), or (N,) for one state; results then lack the first axis.

    Attributes:
        model: what all is read from.

    Raises:
        ModelError: on construction, where the joints share no Lagrangian.
    """

    model: Model

    def __post_init__(self) -> None:
        reason = no_lagrangian(self.model)
        if reason:
            raise ModelError(reason)

    def lagrangian(self, q: ArrayLike, qd: ArrayLike) -> Floats:
        """L(q, qd) in J, eq. (31).

        Torques tell it up to a constant and the time derivative of any function of q, neither of
        which changes a torque.

        Returns:
            (M,), or a number for one state.

        Raises:
            ModelError: the arrays are not of this model's joints.
        """
        x = self._at(q, qd)
        kinetic, potential = self._effects(x)
        told = self._kernel.lagrangian(x, self.model.centres, self.model.weights)
        return _as(q, told * self._unit + kinetic - potential)

    def energy(self, q: ArrayLike, qd: ArrayLike) -> Floats:
        """qd·∂L/∂qd − L in J, kinetic and potential energy together, up to a constant.

        Its rate is the power of the torques that these quantities hold. (M,), or a number.

        Raises:
            ModelError: the arrays are not of this model's joints.
        """
        x = self._at(q, qd)
        kinetic, potential = self._effects(x)
        return _as(q, self._kernel_energy(x) + kinetic + potential)

    def kinetic_energy(self, q: ArrayLike, qd: ArrayLike) -> Floats:
        """Energy beyond that at rest, J: ½ qd·M qd where it is quadratic. (M,), or a number.

        Raises:
            ModelError: the arrays are not of this model's joints.
        """
        x = self._at(q, qd)
        moving = self._kernel_energy(x) - self._kernel_energy(x.at_rest())
        return _as(q, moving + self._effects(x)[0])

    def potential_energy(self, q: ArrayLike) -> Floats:
        """Energy at rest, J, up to a constant. (M,), or a number.

        Raises:
            ModelError: the array is not of this model's joints.
        """
        x = self._at(q)
        return _as(q, self._kernel_energy(x) + self._effects(x)[1])

    def mass_matrix(self, q: ArrayLike, qd: ArrayLike | None = None) -> Floats:
        """M = ∂τ/∂qdd in kg·m², symmetric; `identify` tells where it is not positive.

        Args:
            q: rad.
            qd: rad/s; needed by kernels whose mass matrix depends on it, taken as rest if absent.

        Returns:
            (M, N, N), or (N, N) for one state.

        Raises:
            ModelError: the arrays are not of this model's joints.
        """
        x = self._at(q, qd)
        return _as(q, mass_of(self.torque, x))

    def coriolis_matrix(self, q: ArrayLike, qd: ArrayLike) -> Floats:
        """C(q, qd) of the Christoffel symbols of M, N·m·s/rad: dM/dt − 2 C is skew symmetric.

        Returns:
            (M, N, N), or (N, N) for one state.

        Raises:
            ModelError: the kernel's kinetic energy is not quadratic in velocity, or the arrays are
                not of this model's joints.
        """
        if not self._kernel.quadratic:
            raise ModelError(
                f"the kernel {self._kernel.name} has no Coriolis matrix: its kinetic energy is not "
                "quadratic in velocity; use velocity_torque(), or identify with auto+fri, chain+fri"
                " or energy+fri"
            )
        x = self._at(q, qd)
        eye, zero = np.eye(x.joints), np.zeros((len(x) * x.joints, x.joints))
        q_each = np.repeat(x.q, x.joints, axis=0)
        forth, back = (
            self.torque(States.of(q_each, (x.qd[:, None] + sign * eye).reshape(zero.shape), zero))
            for sign in (1.0, -1.0)
        )
        columns = 0.25 * (forth - back).reshape(len(x), x.joints, x.joints)
        return _as(q, columns.transpose(0, 2, 1))

    def velocity_torque(self, q: ArrayLike, qd: ArrayLike) -> Floats:
        """N·m that velocity adds to gravity: C(q, qd) qd where there is a C.

        Returns:
            (M, N), or (N,) for one state.

        Raises:
            ModelError: the arrays are not of this model's joints.
        """
        x = self._at(q, qd)
        return _as(q, self.torque(x) - self.torque(x.at_rest()))

    def gravity(self, q: ArrayLike) -> Floats:
        """∂V/∂q in N·m: what holds the arm at rest, friction and a constant torque aside.

        Returns:
            (M, N), or (N,) for one state.

        Raises:
            ModelError: the array is not of this model's joints.
        """
        return _as(q, self.torque(self._at(q)))

    def forward(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike) -> Floats:
        """Forward dynamics: the acceleration in rad/s² under these torques, all effects counted.

        It inverts `Model.predict` without time: effects that depend on time or on the past are
        taken as settled.

        Args:
            q, qd, tau: rad, rad/s and N·m.

        Returns:
            (M, N), or (N,) for one state.

        Raises:
            ModelError: the arrays are not of this model's joints, the mass matrix is not positive
                definite at some of the states, or no acceleration gives some of the torques.
        """
        x, torque = self._at(q, qd), self.model.states(q, qd, tau).qdd
        return _as(q, acceleration(lambda x: self.model.predict(x.q, x.qd, x.qdd), x, torque))

    def torque(self, x: States) -> Floats:
        """(M, N) N·m of the Lagrangian: the kernel and the effects that keep energy."""
        out = self.model.lagrangian_torque(x)
        inputs = Inputs.of(x)
        for term, place in self.kept.slices():
            out[:, term.joint] += term.columns(inputs) @ self._coefficients[place]
        return out

    @cached_property
    def kept(self) -> Basis:
        """The effects that keep energy."""
        return self.model.basis.conservative(len(self.model.joints))

    @cached_property
    def _coefficients(self) -> Floats:
        kept = {id(term) for term in self.kept.terms}
        parts = [self.model.coefficients[p] for t, p in self.model.basis.slices() if id(t) in kept]
        return np.concatenate([np.empty(0), *parts])

    @property
    def _kernel(self) -> LagrangianKernel:
        assert isinstance(self.model.kernel, LagrangianKernel)
        return self.model.kernel

    @property
    def _unit(self) -> float:
        return float(self.model.unit[0])

    def _at(self, q: ArrayLike, qd: ArrayLike | None = None) -> States:
        zero = np.zeros(np.shape(q))
        return self.model.states(q, zero if qd is None else qd, zero)

    def _kernel_energy(self, x: States) -> Floats:
        data = self.model.centres, self.model.weights
        moving = np.sum(x.qd * self._kernel.momentum(x, *data), axis=1)
        return np.asarray((moving - self._kernel.lagrangian(x, *data)) * self._unit)

    def _effects(self, x: States) -> tuple[Floats, Floats]:
        """(M,) each: kinetic and potential energy of the effects."""
        inputs, total = Inputs.of(x), np.zeros((2, len(x)))
        for term, place in self.kept.slices():
            found = checked_energies(term.effect, inputs, term.joint, term.shape)
            assert found is not None
            total += [part @ self._coefficients[place] for part in found]
        return total[0], total[1]


def no_lagrangian(model: Model) -> str:
    """Why a model's joints share no Lagrangian, and what to do; empty where they do."""
    if not isinstance(model.kernel, LagrangianKernel) and model.kernel.mechanism is not None:
        return (
            f"the kernel {model.kernel.name} of a known mechanism tells torques only, no "
            "Lagrangian, mass matrix or energy; of a robot from a URDF chain+fri and energy+fri do"
        )
    if not isinstance(model.kernel, LagrangianKernel):
        return (
            f"the joints of a {model.kernel.name} model are learned apart, they share no "
            "Lagrangian, mass matrix or energy; identify with auto+fri, chain+fri, energy+fri or "
            "vrbfs+fri and --scale common"
        )
    if np.ptp(model.unit) > 0.0:
        return (
            "each joint's torque was divided by its own spread, so that the joints share no "
            "Lagrangian, mass matrix or energy; where all efforts are in N·m, identify with "
            "--scale common"
        )
    return ""


def _as(q: ArrayLike, values: Floats) -> Floats:
    """For one state, the one result."""
    return values if np.ndim(q) > 1 else np.asarray(values[0])
