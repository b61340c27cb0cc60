"""The identified model: torques from states, and the parts they are made of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.motion_range import MotionRange
from lagrangian_ff.kernels import Kernel, Learned, States
from lagrangian_ff.kernels.constrained import Linkage
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.motion import Motion

if TYPE_CHECKING:
    from lagrangian_ff.identification.certainty.uncertainty import Uncertainty
    from lagrangian_ff.identification.mechanics.dynamics import Dynamics

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CHUNK_SAMPLES = 20_000
"""States evaluated at once, so that memory stays bounded on long recordings."""


@dataclass(frozen=True)
class Terms:
    """A torque split into what causes it; every array is (M, N), or (N,) for one state, in N·m.

    Attributes:
        gravity: the Lagrangian part at rest.
        inertia: what acceleration adds to it.
        coriolis: what velocity adds: Coriolis, centrifugal, and whatever the kernel took for them.
        effects: friction and every other effect of the basis, by name.
    """

    gravity: Floats
    inertia: Floats
    coriolis: Floats
    effects: Mapping[str, Floats]

    @property
    def friction(self) -> Floats:
        """All effects of the basis together."""
        return sum(self.effects.values(), np.zeros_like(self.gravity))

    @property
    def total(self) -> Floats:
        """The whole torque."""
        return self.gravity + self.inertia + self.coriolis + self.friction


@dataclass(frozen=True)
class Model:
    """Torques τ(q, qd, qdd) of N joints, eq. (45).

    Attributes:
        joints: N names; the columns of every array follow them.
        name: kernel and effects, e.g. `vrbfs+fri`.
        kernel: the Lagrangian part's kernel with its hyperparameters.
        basis: the effects and their shapes.
        centres: (C, N) the states that the kernel is built on: samples, and those where the mass
            matrix is held positive.
        weights: (C, N) a of (45), in units of `unit`.
        coefficients: (B,) b of (45), in physical units.
        unit: (N,) N·m that count as one.
        range: the motion it was identified on.
        record: what identification found, as JSON holds it.
        data: the motion learned from and that held out, at 100 Hz, so that it can be refitted.
        trained: (K,) which samples of it were learned from.
        index: which of them are the first of the centres.
        seen: (S,) which of them determine the weights: these centres, or many more.
        noise: (N,) variance of the noise of few samples in the kernel's units.
        noise_share: (N,) relative standard deviation of the noise between joints.
        steps: the model's history: how it was identified and what was added, as JSON holds it.
        trust: (S, N) in each torque learned from, with Huber's loss; None for squares.
    """

    joints: tuple[str, ...]
    name: str
    kernel: Kernel
    basis: Basis
    centres: States
    weights: Floats
    coefficients: Floats
    unit: Floats
    range: MotionRange
    record: Mapping[str, object]
    data: Motion
    trained: NDArray[np.bool_]
    index: Ints
    seen: Ints
    noise: Floats
    noise_share: Floats
    steps: tuple[Mapping[str, object], ...] = ()
    trust: Floats | None = None

    def require_joints(
        self, held: Sequence[str], source: object, called: object = "the model"
    ) -> None:
        """Refuse what does not hold all joints of the model.

        Args:
            held: the names of its joints.  source: where they are from.
            called: what the model is called, in the message.

        Raises:
            ModelError: a joint is not there; names both lists.
        """
        missing = [name for name in self.joints if name not in held]
        if missing:
            raise ModelError(
                f"{called} is of the joints {', '.join(self.joints)}; {source} holds "
                f"{', '.join(held) or 'none'} and lacks {', '.join(missing)}: it is of another "
                "arm, or its joints were renamed"
            )

    @cached_property
    def dynamics(self) -> "Dynamics":
        """Mass matrix, energies, forward dynamics.

        Raises:
            ModelError: the joints share no Lagrangian; says why and what to do.
        """
        from lagrangian_ff.identification.mechanics.dynamics import Dynamics

        return Dynamics(self)

    @cached_property
    def uncertainty(self) -> "Uncertainty":
        """How sure it is of a torque: variance, intervals, what the data say nothing about.

        The first use solves the model's system again from the data that it keeps, which takes as
        long as it took when it was identified, its hyperparameters given.
        """
        from lagrangian_ff.identification.certainty.uncertainty import Uncertainty

        return Uncertainty.of(self)

    @cached_property
    def quick_uncertainty(self) -> "Uncertainty":
        """The same from 100 of the samples, calibrated when the model was identified: at once.

        Model files of before that was kept are calibrated now, which takes as long as
        `uncertainty`.

        Raises:
            ModelError: it must be calibrated now and cannot: its training motion is too short.
        """
        from lagrangian_ff.identification.certainty.uncertainty import Uncertainty

        return Uncertainty.quick(self)

    @property
    def training_tau(self) -> Floats:
        """(S, N) N·m measured at the samples learned from."""
        return np.asarray(self.data.tau[self.seen])

    def inputs_of_data(self) -> Inputs:
        """All of the data as effects see it."""
        return self.inputs_of(self.data)

    def inputs_of(self, motion: Motion) -> Inputs:
        """A motion of the model's joints as effects see it."""
        x = self.inputs(motion.q, motion.qd, motion.qdd, time=motion.time, segment=motion.segment)
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
        """Torque in N·m.

        Args:
            q, qd, qdd: (M, N) in rad, rad/s, rad/s²; or one state (N,).
            progress: told the share done, for long motions.
            time: (M,) s since the motion began, for effects that depend on it or on the past;
                without it they are taken as settled.
            segment: (M,) samples recorded without interruption share a number.

        Returns:
            (M, N), or (N,) for one state.

        Raises:
            ModelError: the arrays are not of this model's joints.
        """
        x = self.inputs(q, qd, qdd, progress, time=time, segment=segment)
        out = self.torque(x)
        return out if np.ndim(q) > 1 else out[0]

    def torque(self, x: Inputs) -> Floats:
        """(M, N) N·m of a motion that `inputs` has made ready."""
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
    ) -> Inputs:
        """A motion as effects see it, with the model's own rigid-body torque; see `predict`.

        Raises:
            ModelError: the arrays are not of this model's joints.
        """
        x = self.states(q, qd, qdd)
        load = np.empty_like(x.q)
        for first in range(0, len(x), CHUNK_SAMPLES):
            part = slice(first, first + CHUNK_SAMPLES)
            load[part] = self.lagrangian_torque(x.take(part))
            progress(min(1.0, (first + CHUNK_SAMPLES) / len(x)), "predicting")
        load += self.basis.constant(len(self.joints), self.coefficients)
        speed = self.basis.sign_speed(len(self.joints))
        return Inputs.of(x, time, segment, load, load, speed)

    def terms(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *,
        time: ArrayLike | None = None,
        segment: Ints | None = None,
    ) -> Terms:
        """The torque in parts: gravity, inertia, Coriolis, and each effect; see `predict`.

        Raises:
            ModelError: the arrays are not of this model's joints.
        """
        x = self.states(q, qd, qdd)
        gravity = self.lagrangian_torque(x.at_rest())
        inertia = self.lagrangian_torque(x.without_velocity()) - gravity
        inputs = self.inputs(q, qd, qdd, time=time, segment=segment)
        constant = self.basis.constant(len(self.joints), self.coefficients)
        coriolis = inputs.load - constant - gravity - inertia
        effects = self.basis.torque(inputs, self.coefficients)
        if np.ndim(q) > 1:
            return Terms(gravity, inertia, coriolis, effects)
        return Terms(
            gravity[0], inertia[0], coriolis[0], {name: v[0] for name, v in effects.items()}
        )

    @cached_property
    def learned(self) -> Learned:
        """The rigid-body part, in units of `unit`."""
        return self.kernel.learned(self.centres, self.weights)

    def lagrangian_torque(self, x: States) -> Floats:
        """(M, N) N·m of the kernel alone, no effect counted."""
        return self.learned.torque(x) * self.unit

    def states(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> States:
        """States of the model's joints from any arrays of one shape, (M, N) or one state (N,).

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

    def save(self, path: "str | Path") -> None:
        """Write the model to a file; see `storage`."""
        from lagrangian_ff.identification import storage

        storage.save(self, Path(path))

    @classmethod
    def load(cls, path: "str | Path", linkage: Linkage | None = None) -> "Model":
        """Read a model from a file; see `storage`.

        Args:
            path: of the file.
            linkage: of a model whose loops are closed.

        Raises:
            ModelError: there is no such file, it is damaged, no model, or of a newer version.
        """
        from lagrangian_ff.identification import storage

        return storage.load(Path(path), linkage)
