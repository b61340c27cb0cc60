"""Torques of an identified model from states, and the parts they are made of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.effects import Curve, Inputs, effect_of
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.problem import Prior
from lagrangian_ff.kernels import Kernel, Learned, States
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.motion import Motion

CHUNK_SAMPLES = 20_000
"""States evaluated at once, so that memory stays bounded on long recordings."""
ROOM = 1.5
"""Times the largest torque predicted of some samples that the torque between them may reach."""
WILD = 6.0
"""Times the error that nine of ten torques stay below: ten standard deviations of normal ones."""
STILL = 1e-3
"""rad, rad/s, rad/s² within which a joint counts as standing."""


@dataclass(frozen=True)
class MotionRange:
    """The box of states a model was identified on.

    Attributes:
        q_low, q_high: (N,) rad.  qd_max: (N,) rad/s.  qdd_max: (N,) rad/s².
        tau_max: (N,) N·m, the largest torque.
    """

    q_low: Floats
    q_high: Floats
    qd_max: Floats
    qdd_max: Floats
    tau_max: Floats

    @classmethod
    def of(cls, x: States, tau: Floats) -> "MotionRange":
        """Return the range of these states and torques."""
        speed, hardness, torque = (np.abs(one).max(axis=0) for one in (x.qd, x.qdd, tau))
        return cls(x.q.min(axis=0), x.q.max(axis=0), speed, hardness, torque)

    def without_wild_torque(
        self, joints: Sequence[str], tau: Floats, left_out: Floats
    ) -> tuple["MotionRange", list[str]]:
        """Return the range whose torques the model itself makes credible, and what it lowered.

        The limit of the feedforward follows `tau_max`, so that a few false efforts, or a blow in
        the recording, must not raise it. It ends at `ROOM` times the largest torque predicted for
        blocks left out, and `WILD` times the error that nine of ten torques stay below.

        Args:
            tau: (S, N) N·m measured.  left_out: (S, N) predicted for them, not learned from them.
        """
        error = np.quantile(np.abs(tau - left_out), 0.9, axis=0)
        most = ROOM * np.abs(left_out).max(axis=0) + WILD * error
        notes = [
            f"{joint}: efforts reach {self.tau_max[n]:.4g} N·m, which nothing else in the "
            f"recording explains; its range, and the limit of its feedforward, end at "
            f"{most[n]:.4g} N·m"
            for n, joint in enumerate(joints)
            if self.tau_max[n] > most[n]
        ]
        return replace(self, tau_max=np.minimum(self.tau_max, most)), notes

    def excess(self, x: States) -> Floats:
        """Return (M, N) how far outside each joint's state is, in parts of the range; 0 inside.

        It is the largest excess of position, velocity and acceleration.
        """
        width = np.maximum(self.q_high - self.q_low, 2.0 * STILL)
        over = np.maximum(np.maximum(self.q_low - x.q, x.q - self.q_high) / width, 0.0)
        for rate, limit in ((x.qd, self.qd_max), (x.qdd, self.qdd_max)):
            over = np.maximum(over, np.abs(rate) / np.maximum(limit, STILL) - 1.0)
        return over

    @classmethod
    def from_record(cls, record: dict[str, list[float]]) -> "MotionRange":
        """Return the range that a record describes."""
        return cls(**{f.name: np.array(record[f.name], dtype=np.float64) for f in fields(cls)})


@dataclass(frozen=True)
class Terms:
    """A torque in parts by cause; every array is (M, N), or (N,) for one state, in N·m.

    Attributes:
        gravity: the Lagrangian part at rest.
        inertia: what acceleration adds to it.
        coriolis: what velocity adds: Coriolis and centrifugal torque, as the kernel has them.
        effects: friction and every other effect of the basis, by name.
    """

    gravity: Floats
    inertia: Floats
    coriolis: Floats
    effects: Mapping[str, Floats]

    @property
    def friction(self) -> Floats:
        """Return the torque of all effects that dissipate energy."""
        return by_part(self)["friction"]

    @property
    def total(self) -> Floats:
        """Return the whole torque."""
        rigid = self.gravity + self.inertia + self.coriolis
        return rigid + sum(self.effects.values(), np.zeros_like(self.gravity))


def by_part(terms: Terms) -> dict[str, Floats]:
    """Return the torque of each of `effects.PARTS` in N·m, every effect with the part it goes with.

    A constant offset goes with gravity: without an independent measurement of one of them, an
    identification may share the mean of gravity between the two in any way.
    """
    parts = {
        "gravity": terms.gravity,
        "inertia": terms.inertia,
        "coriolis": terms.coriolis,
        "friction": np.zeros_like(terms.gravity),
    }
    for name, torque in terms.effects.items():
        effect = effect_of(name)
        part = effect.part if effect else "friction"
        parts[part] = parts[part] + torque
    return parts


@dataclass(frozen=True)
class TorqueModel:
    """Torques τ(q, qd, qdd) of N joints, eq. (45).

    Its methods raise ModelError for arrays that are not of its joints.

    Attributes:
        joints: N names; the columns of every array follow them.
        name: kernel and effects, e.g. `vrbfs+fri`.
        prior: kernel, noise, scaling and basis, with what was chosen of them.
        centres: (C, N) the states that the kernel is built on: samples, and those where the mass
            matrix is held positive.
        weights: (C, N) a of (45), in units of `unit`.
        coefficients: (B,) b of (45), in physical units.
        range: the motion it was identified on.
        record: findings of the identification, as JSON holds them.
        data: the motion learned from and that held out, at 100 Hz, for a refit.
        trained: (K,) which samples of it were learned from.
        index: positions of the samples that are the first centres.
        seen: (S,) positions of those that determine the weights: these centres, or many more.
        steps: the model's history, identification and additions, as JSON holds it.
        irls_weight: (S, N) of each torque learned from, with Huber's loss; None for squares.
    """

    joints: tuple[str, ...]
    name: str
    prior: Prior
    centres: States
    weights: Floats
    coefficients: Floats
    range: MotionRange
    record: Mapping[str, object]
    data: Motion
    trained: NDArray[np.bool_]
    index: Ints
    seen: Ints
    steps: tuple[Mapping[str, object], ...] = ()
    irls_weight: Floats | None = None

    @property
    def kernel(self) -> Kernel:
        """Return the Lagrangian part's kernel with its hyperparameters."""
        return self.prior.kernel

    @property
    def basis(self) -> Basis:
        """Return the effects and their shapes."""
        return self.prior.basis

    @property
    def unit(self) -> Floats:
        """Return (N,) N·m that count as one."""
        return self.prior.scaling.unit

    def require_joints(
        self, held: Sequence[str], source: object, called: object = "the model"
    ) -> None:
        """Refuse a motion that lacks a joint of the model.

        Args:
            held: names of its joints.  source: of the motion, for the message.
            called: name of the model in the message.

        Raises:
            ModelError: a joint is missing; names both lists.
        """
        missing = [name for name in self.joints if name not in held]
        if missing:
            raise ModelError(
                f"{called} is of the joints {', '.join(self.joints)}; {source} holds "
                f"{', '.join(held) or 'none'} and lacks {', '.join(missing)}: it is of another "
                "arm, or its joints were renamed"
            )

    def require_motion(self, motion: Motion) -> None:
        """Refuse a motion of other joints, or whose effort holds another torque than the model's.

        Raises:
            ModelError: it lacks a joint, or was read with another `effort`; names both.
        """
        self.require_joints(motion.joints, motion.source)
        if "effort" in motion.conditioning and motion.effort != self.data.effort:
            raise ModelError(
                f"the model was identified from an effort that is {self.data.effort}, and "
                f"{motion.source} was read as {motion.effort}: leave --effort out to read it as "
                "the model's recordings were, or identify a model from such recordings"
            )

    def inputs_of(self, motion: Motion) -> Inputs:
        """Return a motion of the model's joints as effects see it, with its torque."""
        q, qd, qdd, temperature = motion.q, motion.qd, motion.qdd, motion.temperature
        when, segment = motion.time, motion.segment
        return self.with_torque(
            self.inputs(q, qd, qdd, time=when, segment=segment, temperature=temperature)
        )

    def with_torque(self, x: Inputs) -> Inputs:
        """Return a motion that `inputs` has prepared, with the model's whole torque."""
        return replace(x, torque=x.load + self.basis.beside_load(x, self.coefficients))

    def predict(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        progress: Progress = silent,
        *,
        time: ArrayLike | None = None,
        segment: Ints | None = None,
    ) -> Floats:
        """Return the torque in N·m.

        Args:
            q, qd, qdd: (M, N) in rad, rad/s, rad/s²; or one state (N,).
            progress: receives the share done, 0 to 1.
            time: (M,) s since the motion began, for effects that depend on it or on the past;
                without it they are taken as settled.
            segment: (M,) samples recorded without interruption share a number.

        Returns:
            (M, N), or (N,) for one state.
        """
        x = self.inputs(q, qd, qdd, progress, time=time, segment=segment)
        out = self.torque(x)
        return out if np.ndim(q) > 1 else out[0]

    def torque(self, x: Inputs) -> Floats:
        """Return (M, N) N·m of a motion that `inputs` has prepared."""
        out = x.load - self.basis.constant(len(self.joints), self.coefficients)
        for torque in self.basis.torque(x, self.coefficients).values():
            out += torque
        return out

    def inputs(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        progress: Progress = silent,
        *,
        time: ArrayLike | None = None,
        segment: Ints | None = None,
        temperature: Floats | None = None,
    ) -> Inputs:
        """Return a motion as effects see it, with the model's rigid-body torque; see `predict`."""
        x = self.states(q, qd, qdd)
        load = np.empty_like(x.q)
        for first in range(0, len(x), CHUNK_SAMPLES):
            part = slice(first, first + CHUNK_SAMPLES)
            load[part] = self.lagrangian_torque(x.take(part))
            progress(min(1.0, (first + CHUNK_SAMPLES) / len(x)), "predicting")
        load += self.basis.constant(len(self.joints), self.coefficients)
        speed = self.basis.sign_speed(len(self.joints))
        return Inputs.of(x, time, segment, load, load, speed, temperature)

    def curves_outside(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, time: ArrayLike | None = None
    ) -> dict[str, float]:
        """Return, in words, the curves that a motion leaves, with the share of it outside.

        Args:
            q, qd, qdd, time: see `predict`.
        """
        curves = [term for term in self.basis.terms if isinstance(term.effect, Curve)]
        found: dict[str, float] = {}
        x = self.inputs(q, qd, qdd, time=time) if curves else None
        for term in curves:
            assert x is not None
            assert isinstance(term.effect, Curve)
            share = float(np.mean(term.effect.outside(x, term.joint)))
            if share > 0.0:
                found[f"{term.effect.meaning} on {self.joints[term.joint]}"] = share
        return found

    def terms(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *,
        time: ArrayLike | None = None,
        segment: Ints | None = None,
        temperature: Floats | None = None,
    ) -> Terms:
        """Return the torque as gravity, inertia, Coriolis, and each effect; see `predict`."""
        x = self.states(q, qd, qdd)
        gravity = self.lagrangian_torque(x.at_rest())
        inertia = self.lagrangian_torque(x.without_velocity()) - gravity
        inputs = self.inputs(q, qd, qdd, time=time, segment=segment, temperature=temperature)
        constant = self.basis.constant(len(self.joints), self.coefficients)
        coriolis = inputs.load - constant - gravity - inertia
        effects = self.basis.torque(inputs, self.coefficients)
        if np.ndim(q) > 1:
            return Terms(gravity, inertia, coriolis, effects)
        single = {name: torque[0] for name, torque in effects.items()}
        return Terms(gravity[0], inertia[0], coriolis[0], single)

    @cached_property
    def learned(self) -> Learned:
        """Return the rigid-body part, in units of `unit`."""
        return self.kernel.learned(self.centres, self.weights)

    def lagrangian_torque(self, x: States) -> Floats:
        """Return (M, N) N·m of the kernel alone, without effects."""
        return self.learned.torque(x) * self.unit

    def states(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> States:
        """Return states of the model's joints from arrays (M, N), or one state (N,).

        Raises:
            ModelError: the shapes differ, or are not of this model's joints.
        """
        x = States.of(q, qd, qdd)
        if x.joints != len(self.joints):
            raise ModelError(
                f"the model is of {len(self.joints)} joints ({', '.join(self.joints)}), "
                f"got states of {x.joints}"
            )
        return x
