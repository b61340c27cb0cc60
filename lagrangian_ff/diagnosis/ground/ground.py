"""The whitened residual on which candidates are judged.

With the torques y of S samples, G the Gram matrix of the rigid-body prior plus the noise, U its
upper factor and Φ the columns of everything already explained, the residual U⁻ᵀ(y − Φ b), divided
by the amplitude, is white where nothing is missing. Because the prior whitens, a small effect
with a signature of its own is seen although the rigid-body part is unknown.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from lagrangian_ff.diagnosis.ground.prior import Prior
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.solving.solution import LeftOut
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.kernels import States, threads
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MANY = 64
"""Columns of a joint from which on its response is worth its making."""
ROWS_AT_ONCE = 480
AVERAGED = 0.07  # s, over which samples are averaged at most
TANGENT = 0.03
"""Relative step by which a shape is varied, so that its error is not taken for an effect."""


@dataclass(frozen=True)
class Extra:
    """Columns that are explained away without being an effect of the model.

    Attributes:
        joint: whose torque.  columns: (S, K).
    """

    joint: int
    columns: Floats


@dataclass(frozen=True)
class Ground:
    """One motion, whitened.

    Attributes:
        motion: all of it.
        index: (S,) the samples used.
        block: (S,) the block of time each lies in.
        inputs: the whole motion as effects see it.
        seen: the samples used, as effects see them.
        prior: of rigid-body torque and noise.
        basis: the effects already in the model, each free on this motion.
        extra: what else is explained away.
        system: the factored system.
        residual: (S N,) whitened, of variance one where nothing is missing.
        span: (S N, B) orthonormal columns of what is explained already, whitened.
    """

    motion: Motion
    index: Ints
    block: Ints
    inputs: Inputs
    seen: Inputs
    prior: Prior
    basis: Basis
    extra: tuple[Extra, ...]
    system: System
    residual: Floats
    span: Floats

    @property
    def joints(self) -> int:
        """The number of joints N."""
        return len(self.motion.joints)

    @property
    def amplitude(self) -> float:
        """What one standard deviation of the whitened residual is, in units of the prior."""
        return float(np.sqrt(self.system.amplitude))

    @property
    def noise(self) -> Floats:
        """(N,) N·m, standard deviation of a sample of each joint's torque that is not explained."""
        return np.asarray(np.sqrt(self.prior.noise) * self.amplitude * self.prior.unit)

    @property
    def spread(self) -> Floats:
        """(N,) N·m, root mean square of each joint's torque about its mean."""
        return np.asarray(np.std(self.motion.tau, axis=0))

    @cached_property
    def starts(self) -> Ints:
        """(B,) the first row of each block among the S N whitened rows."""
        rows = np.repeat(self.block, self.joints)
        return np.asarray(np.flatnonzero(np.diff(rows, prepend=-1)), dtype=np.int64)

    @cached_property
    def _responses(self) -> dict[int, Floats]:
        return {}

    def response(self, joint: int) -> Floats:
        """(S, S N) what a torque of one joint at each sample whitens to; zero before the sample.

        Those of two joints are kept, for two threads: columns of a joint have S rows that are not
        zero, and many of them cost a third of a triangular solve each once these are known.
        """
        found = self._responses.get(joint)
        if found is None:
            found = _response(self.system.upper, self.joints, joint)
            for oldest in list(self._responses)[:-1]:
                self._responses.pop(oldest, None)
            self._responses[joint] = found
        return found

    def forget(self) -> None:
        """Let go of what `response` keeps."""
        self._responses.clear()

    def relaid(
        self,
        prior: Prior | None = None,
        basis: Basis | None = None,
        extra: tuple[Extra, ...] | None = None,
    ) -> "Ground":
        """The same motion with another prior, basis, or what is explained besides; see `lay`.

        Nothing is factored again where the prior stays.
        """
        same = prior is None or prior is self.prior
        return lay(
            self.motion,
            self.index,
            self.block,
            self.inputs,
            self.prior if prior is None else prior,
            self.basis if basis is None else basis,
            self.extra if extra is None else extra,
            self.seen,
            self.system if same else None,
        )

    def whiten(self, columns: Floats, joint: int, *, coarse: bool = False) -> Floats:
        """(S N, K) columns (S, K) of one joint's torque, whitened, nothing projected out yet.

        Args:
            columns: (S, K) N·m.  joint: whose.
            coarse: many at once come in single precision: twice as fast, and exact enough to
                choose by.
        """
        samples, count = columns.shape
        scaled = np.asarray(columns.T) / (self.prior.unit[joint] * self.amplitude)
        if count >= MANY or joint in self._responses:
            return _multiplied(scaled, self.response(joint), coarse=coarse)
        full = np.zeros((count, samples, self.joints))
        full[:, :, joint] = scaled
        flat = full.reshape(count, -1).T
        return np.asarray(
            solve_triangular(self.system.upper, flat, trans=1, check_finite=False, overwrite_b=True)
        )

    def project(self, whitened: Floats) -> Floats:
        """(S N, K) what of whitened columns the model's own columns do not explain."""
        return np.asarray(whitened - self.span @ (self.span.T @ whitened))

    def inputs_of(self, motion: Motion) -> Inputs:
        """Any motion of these joints as effects see it, load and torque as fitted here.

        The load is what goes through the gear: the rotors' own share is left out, and constant
        torques are counted in, which over a part of the range are gravity.
        """
        x = States.of(motion.q, motion.qd, motion.qdd)
        speed = self.basis.sign_speed(self.joints)
        inputs = Inputs.of(x, motion.time, motion.segment, sign_speed=speed)
        load, torque = self._predicted(
            inputs, self.system.weights, self.system.coefficients[: self.basis.size]
        )
        return replace(inputs, load=load, torque=torque, rotor=self._rotor)

    @property
    def _rotor(self) -> Floats:
        weights = self.system.weights.reshape(len(self.index), self.joints)
        return self.prior.rotor(self.seen, weights)

    def unseen_inputs(self) -> Inputs:
        """The samples used as effects see them, the load predicted without their own block.

        A load that was fitted to the very torque it is to explain would hold the answer. The same
        holds of the whole motion behind these samples.
        """
        _, place = np.unique(self.block, return_inverse=True)
        ends = np.flatnonzero(np.diff(place, prepend=-1, append=-1)) * self.joints
        left = _left_out(self.system, ends.tolist())
        weights = self.system.weights_without(left)
        between = 0.5 * (self.index[1:] + self.index[:-1])
        nearest = place[np.searchsorted(between, np.arange(len(self.inputs)))]
        load, torque = np.zeros((2, *self.inputs.q.shape))

        def predict(number: int) -> None:
            here = np.flatnonzero(nearest == number)
            coefficients = self.system.coefficients + left[number].change
            load[here], torque[here] = self._predicted(
                self.inputs.take(here), weights[:, number], coefficients[: self.basis.size]
            )

        threads.side_by_side(predict, range(len(left)))
        whole = replace(self.inputs, load=load, torque=torque, rotor=self._rotor)
        return whole.take(self.index, self.seen.window)

    def _predicted(self, x: Inputs, weights: Floats, coefficients: Floats) -> tuple[Floats, Floats]:
        """(M, N) N·m of load and of all torque, for weights (S N,) and basis coefficients."""
        by_joint = weights.reshape(len(self.index), self.joints)
        load = self.prior.torque(x, self.seen, by_joint)
        load += self.basis.constant(self.joints, coefficients)
        rotors = self.prior.rotors(x, self.seen, by_joint)
        x = replace(x, load=load, torque=load)
        return load, load + rotors + self.basis.beside_load(x, coefficients)


def window_of(index: Ints, motion: Motion) -> int:
    """How many samples about each of those used are averaged: all between them, but not for long.

    Noise falls; what rings faster than some Hz would too.
    """
    if len(index) < 2:
        return 1
    step = float(np.median(np.diff(motion.time)))
    most = min(float(np.median(np.diff(index))), AVERAGED / step)
    return max(1, 2 * int((most + 1e-6 - 1.0) // 2) + 1)


def lay(
    motion: Motion,
    index: Ints,
    block: Ints,
    inputs: Inputs,
    prior: Prior,
    basis: Basis,
    extra: Sequence[Extra] = (),
    seen: Inputs | None = None,
    like: System | None = None,
) -> Ground:
    """Factor and whiten a motion; the tangents of the basis' shapes are explained away too.

    Args:
        motion, index, block, inputs, prior, basis, extra: see `Ground`.
        seen: the samples used; without them, of the inputs.
        like: of the same samples and prior, whose factor is taken.

    Raises:
        NotPositiveDefiniteError: the noise is too small for the arithmetic.
    """
    seen = seen or inputs.take(index, window_of(index, motion))
    tangents = [*extra, *_tangents(basis, seen)]
    system = factored(seen.mean(motion.tau), seen, prior, basis, tangents, like)
    span, triangle = np.linalg.qr(system.white_design)
    weak = np.abs(np.diag(triangle)) < 1e-9 * np.abs(triangle).max(initial=0.0)
    span = span[:, ~weak]
    white = system.white_target - span @ (span.T @ system.white_target)
    residual = white / np.sqrt(system.amplitude)
    return Ground(
        motion, index, block, inputs, seen, prior, basis, tuple(extra), system, residual, span
    )


def factored(
    tau: Floats,
    x: Inputs,
    prior: Prior,
    basis: Basis,
    extra: Sequence[Extra] = (),
    like: System | None = None,
) -> System:
    """The system of some samples: tau (S, N) N·m, x (S, N); see `lay`."""
    samples, joints = tau.shape
    design = basis.design(x)
    if extra:
        more = [np.zeros((samples, joints, one.columns.shape[1])) for one in extra]
        for place, one in zip(more, extra, strict=True):
            place[:, one.joint, :] = one.columns
        design = np.concatenate([design, *more], axis=2)
    design /= prior.unit[None, :, None]
    flat, target = design.reshape(samples * joints, -1), (tau / prior.unit).ravel()
    if like is not None:
        return like.of(flat, target)
    return System.factor(prior.gram(x), np.tile(prior.noise, samples), flat, target)


def _left_out(system: System, ends: Sequence[int]) -> list[LeftOut]:
    """As `System.left_out`, of blocks of rows that follow each other, begun and ended by `ends`.

    Only the rows of U⁻¹ of one block are there at a time.
    """
    white = solve_triangular(system.upper, system.white_design, check_finite=False)

    def without(rows: tuple[int, int]) -> LeftOut:
        first, last = rows
        half = _inverse_rows(system.upper, first, last)
        mine = white[first:last]
        projected = half @ half.T - mine @ system.covariance @ mine.T
        residual = np.linalg.solve(projected, system.weights[first:last])
        change = -system.covariance @ (mine.T @ residual)
        return LeftOut(np.arange(first, last), residual, change)

    system.covariance  # noqa: B018  made once, before the threads ask for it
    return threads.side_by_side(without, pairwise(ends))


def _inverse_rows(upper: Floats, first: int, last: int) -> Floats:
    """(R, n - first) rows of U⁻¹, from where they are not zero."""
    size = len(upper) - first
    out = np.zeros((last - first, size))
    own = np.triu(upper[first:last, first:last])
    out[:, : last - first] = solve_triangular(own, np.eye(len(own)), check_finite=False)
    for begin in range(last - first, size, ROWS_AT_ONCE):
        here = slice(begin, min(begin + ROWS_AT_ONCE, size))
        there = slice(first + here.start, first + here.stop)
        across = -out[:, :begin] @ upper[first : first + begin, there]
        corner = upper[there, there]
        out[:, here] = solve_triangular(corner, across.T, trans=1, check_finite=False).T
    return out


def _response(upper: Floats, joints: int, joint: int) -> Floats:
    """(S, S N) rows of U⁻¹ of one joint: block by block, nothing is done where they are zero."""
    size = len(upper)
    out = np.zeros((size // joints, size))
    for first in range(0, size, ROWS_AT_ONCE):
        here = slice(first, min(first + ROWS_AT_ONCE, size))
        for before in range(0, first, ROWS_AT_ONCE):
            there = slice(before, before + ROWS_AT_ONCE)
            known = slice(0, _samples(there.stop, joints))
            out[known, here] -= out[known, there] @ upper[there, here]
        known = slice(0, _samples(here.stop, joints))
        own = np.arange(joint, size, joints)
        own = own[(own >= here.start) & (own < here.stop)]
        out[own // joints, own] = 1.0
        corner = upper[here, here]
        out[known, here] = solve_triangular(
            corner, out[known, here].T, trans=1, check_finite=False
        ).T
    return out


def _multiplied(columns: Floats, response: Floats, *, coarse: bool) -> Floats:
    """(S N, K) the columns (K, S) whitened, nothing done where the response is zero."""
    kind = np.float32 if coarse else np.float64
    samples, size = response.shape
    given: Floats = np.ascontiguousarray(columns, dtype=kind)
    out = np.empty((len(columns), size), dtype=kind)
    for first in range(0, size, ROWS_AT_ONCE):
        here = slice(first, first + ROWS_AT_ONCE)
        known = slice(0, _samples(min(here.stop, size), size // samples))
        part: Floats = np.asarray(response[known, here], dtype=kind)
        out[:, here] = given[:, known] @ part
    return out.T


def _samples(rows: int, joints: int) -> int:
    """How many samples these first rows belong to."""
    return -(-rows // joints)


def _tangents(basis: Basis, x: Inputs) -> list[Extra]:
    """How the columns change with the shapes of the effects: to first order, their error."""
    found = []
    for term in basis.terms:
        if len(term.effect.parameters) != 1:
            continue
        for shape in term.effect.shapes:
            if shape.whole or not term.shape.get(shape.name, 0.0) > 0.0:
                continue
            value = term.shape[shape.name]
            up, down = (
                replace(term, shape={**term.shape, shape.name: value * factor})
                for factor in (1.0 + TANGENT, 1.0 - TANGENT)
            )
            found.append(Extra(term.joint, (up.columns(x) - down.columns(x)) / TANGENT))
    return found
