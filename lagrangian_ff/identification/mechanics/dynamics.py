"""The Lagrangian of a model, its energies, M, C, g, and forward dynamics.

The torque of a Lagrangian is affine in acceleration, and where kinetic energy is quadratic in
velocity, the velocity's part of it is a quadratic form. For every kernel, torques at a few
states then give, exactly and without differentiation,

    M e_j = τ(q, qd, e_j) − τ(q, qd, 0),      g = τ(q, 0, 0),
    C e_j = ¼ (τ(q, qd + e_j, 0) − τ(q, qd − e_j, 0)),

the last by polarisation: the torque of the velocity is its form B(qd, qd), and B(qd, e_j) are the
Christoffel symbols of M times qd.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import Inputs, checked_energies
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.predicting import TorqueModel
from lagrangian_ff.kernels import LagrangianKernel, States
from lagrangian_ff.recording.motion import WITHOUT_GRAVITY

Torque = Callable[[States], Floats]

ROUNDS = 30
"""Steps at most towards the acceleration, for torques that are not affine in it."""
CLOSE = 1e-9
"""Share of the torque that may be left."""
NEAR = 1e-3
"""rad/s²: step of the differences for torques that are not affine in acceleration."""


@dataclass(frozen=True)
class Dynamics:
    """The rigid-body quantities of a model whose joints share one Lagrangian.

    They include the kernel and the effects that keep energy (`Effect.energies`: rotors, springs,
    counterbalances, cogging), but not friction or a constant torque; `forward` has all effects.
    A constant torque may hold a part of gravity, which looks alike over a limited range.

    Kernels of the paper (`vrbf`, `vrbfs`) have no quadratic kinetic energy: their mass matrix
    ∂τ/∂qdd depends on velocity as well, and they have no Coriolis matrix.

    Every argument is (M, N), or (N,) for one state; results then lack the first axis.

    Attributes:
        model: to evaluate.

    Raises:
        ModelError: the joints share no Lagrangian; in methods, an array is not of its joints.
    """

    model: TorqueModel

    def __post_init__(self) -> None:
        reason = no_lagrangian(self.model)
        if reason:
            raise ModelError(reason)

    def lagrangian(self, q: ArrayLike, qd: ArrayLike) -> Floats:
        """Return L(q, qd), (M,), in J, eq. (31).

        Torques determine it up to a constant and the time derivative of any function of q.
        """
        x = self._at(q, qd)
        kinetic, potential = self._effects(x)
        rigid = self._kernel.lagrangian(x, self.model.centres, self.model.weights)
        return _as(q, rigid * self._unit + kinetic - potential)

    def energy(self, q: ArrayLike, qd: ArrayLike) -> Floats:
        """Return qd·∂L/∂qd − L, (M,), in J: the whole energy, up to a constant.

        Its rate is the power of the torques of the Lagrangian.
        """
        x = self._at(q, qd)
        kinetic, potential = self._effects(x)
        return _as(q, self._kernel_energy(x) + kinetic + potential)

    def kinetic_energy(self, q: ArrayLike, qd: ArrayLike) -> Floats:
        """Return (M,) the energy in J beyond that at rest: ½ qd·M qd if quadratic."""
        x = self._at(q, qd)
        moving = self._kernel_energy(x) - self._kernel_energy(x.at_rest())
        return _as(q, moving + self._effects(x)[0])

    def potential_energy(self, q: ArrayLike) -> Floats:
        """Return (M,) the energy at rest in J, up to a constant.

        Raises:
            ModelError: the model's effort holds no gravity.
        """
        self._require_gravity()
        x = self._at(q)
        return _as(q, self._kernel_energy(x) + self._effects(x)[1])

    def mass_matrix(self, q: ArrayLike, qd: ArrayLike | None = None) -> Floats:
        """Return M = ∂τ/∂qdd, (M, N, N), in kg·m², symmetric.

        Args:
            q: rad.  qd: rad/s; for kernels whose mass matrix depends on it; None is rest.
        """
        x = self._at(q, qd)
        return _as(q, mass_of(self.torque, x))

    def coriolis_matrix(self, q: ArrayLike, qd: ArrayLike) -> Floats:
        """Return C(q, qd), (M, N, N), of the Christoffel symbols of M in N·m·s/rad.

        dM/dt − 2 C is skew symmetric.

        Raises:
            ModelError: the kernel's kinetic energy is not quadratic in velocity.
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
        """Return (M, N) N·m that velocity adds to gravity: C(q, qd) qd if there is a C."""
        x = self._at(q, qd)
        return _as(q, self.torque(x) - self.torque(x.at_rest()))

    def gravity(self, q: ArrayLike) -> Floats:
        """Return ∂V/∂q, (M, N) N·m, which holds the arm at rest without friction or offset.

        Raises:
            ModelError: the model's effort holds no gravity.
        """
        self._require_gravity()
        return _as(q, self.torque(self._at(q)))

    def forward(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike) -> Floats:
        """Return the acceleration, (M, N) rad/s², under these torques, with all effects.

        It inverts `Model.predict` without time: effects that depend on time or on the past are
        taken as settled.

        Args:
            q, qd, tau: rad, rad/s and N·m.

        Raises:
            ModelError: the mass matrix is not positive definite at some of the states, or no
                acceleration gives some of the torques.
        """
        x, torque = self._at(q, qd), self.model.states(q, qd, tau).qdd
        return _as(q, acceleration(lambda x: self.model.predict(x.q, x.qd, x.qdd), x, torque))

    def torque(self, x: States) -> Floats:
        """Return (M, N) N·m of the Lagrangian: the kernel and the effects that keep energy."""
        out = self.model.lagrangian_torque(x)
        inputs = Inputs.of(x)
        for term, place in self.kept.slices():
            out[:, term.joint] += term.columns(inputs) @ self._coefficients[place]
        return out

    def _require_gravity(self) -> None:
        if self.model.data.effort == WITHOUT_GRAVITY:
            raise ModelError(
                "the model was identified from an effort without gravity, and knows nothing of it: "
                "take gravity from the driver that removed it, or identify from total torque"
            )

    @cached_property
    def kept(self) -> Basis:
        """Return the effects that keep energy."""
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
        """Return kinetic and potential energy of the effects, (M,) each."""
        inputs, total = Inputs.of(x), np.zeros((2, len(x)))
        for term, place in self.kept.slices():
            found = checked_energies(term.effect, inputs, term.joint, term.shape)
            assert found is not None
            total += [part @ self._coefficients[place] for part in found]
        return total[0], total[1]


def no_lagrangian(model: TorqueModel) -> str:
    """Return why a model's joints share no Lagrangian and what to do; empty if they do."""
    if not isinstance(model.kernel, LagrangianKernel) and model.kernel.mechanism is not None:
        return (
            f"the kernel {model.kernel.name} of a known mechanism has torques only, no "
            "Lagrangian, mass matrix or energy; for a robot from a URDF use chain+fri or energy+fri"
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
    """Return the values, or for one state q (N,) the only one."""
    return values if np.ndim(q) > 1 else np.asarray(values[0])


def mass_of(torque: Torque, x: States, step: float = 1.0) -> Floats:
    """Return (M, N, N) the derivative of a torque by acceleration, by forward differences.

    Args:
        torque: (M, N) N·m of states; if it is affine in acceleration, any step is exact.
        x: (M, N).  step: rad/s².
    """
    joints = x.joints
    q, qd, qdd = (np.repeat(part, joints + 1, axis=0) for part in (x.q, x.qd, x.qdd))
    qdd += step * np.tile(np.vstack([np.zeros(joints), np.eye(joints)]), (len(x), 1))
    found = torque(States.of(q, qd, qdd)).reshape(len(x), joints + 1, joints)
    return np.asarray((found[:, 1:] - found[:, :1]).transpose(0, 2, 1)) / step


def least(mass: Floats) -> tuple[Floats, Floats]:
    """Return the least eigenvalue (M,) of each mass matrix (M, N, N), and its vector (M, N)."""
    values, vectors = np.linalg.eigh(0.5 * (mass + mass.transpose(0, 2, 1)))
    return values[:, 0], vectors[:, :, 0]


def acceleration(torque: Torque, x: States, wanted: Floats) -> Floats:
    """Return (M, N) rad/s² at which a torque has the wanted value, by Newton's method.

    One step is enough if the torque is affine in acceleration; an effect that follows the torque
    itself takes more.

    Args:
        torque: (M, N) N·m of states.
        x: (M, N); their acceleration is ignored.
        wanted: (M, N) N·m.

    Raises:
        ModelError: the mass matrix is not positive definite at some of the states, or no
            acceleration gives some of the torques.
    """
    qdd = np.zeros_like(x.q)
    mass = mass_of(torque, replace(x, qdd=qdd))
    _require_positive(mass)
    start = torque(replace(x, qdd=qdd))
    enough = CLOSE * (np.abs(wanted).max(axis=1) + np.abs(start).max(axis=1))
    left, open_ = wanted - start, np.arange(len(x))
    for _ in range(ROUNDS):
        qdd[open_] += np.linalg.solve(mass, left[:, :, None])[:, :, 0]
        left = wanted - torque(replace(x, qdd=qdd))
        open_ = np.flatnonzero(np.abs(left).max(axis=1) > enough)
        if not len(open_):
            return qdd
        left = left[open_]
        mass = mass_of(torque, replace(x, qdd=qdd).take(open_), NEAR)
    raise ModelError(
        f"no acceleration was found that gives the torque at sample {open_[0]}: an "
        "effect of the model follows the torque itself too strongly there"
    )


def _require_positive(mass: Floats) -> None:
    values, _ = least(mass)
    bad = np.flatnonzero(values <= 0.0)
    if len(bad):
        raise ModelError(
            f"the learned mass matrix is not positive definite at {len(bad)} of {len(mass)} "
            f"states, the first of them sample {bad[0]} (least eigenvalue {values[bad[0]]:.3g} "
            "kg·m²): forward dynamics is not defined there; stay within the motion the model was "
            "identified on, identify with more motion, or with --positive"
        )
