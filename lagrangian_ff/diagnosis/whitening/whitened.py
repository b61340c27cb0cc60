"""The whitened residual that candidates are compared with.

Let y be the torques of S samples, G the Gram matrix of the rigid-body prior plus the noise, U its
upper Cholesky factor and Φ the columns of everything already explained. The residual U⁻ᵀ(y − Φ b),
divided by the amplitude, is white if nothing is missing. The prior whitens, so that a small effect
stands out although the rigid-body part is unknown.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.linalg import solve_triangular

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis.whitening.errors import error_of_lag, errors_of_shapes
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.problem import Nuisance, Problem, within
from lagrangian_ff.identification.samples import Samples
from lagrangian_ff.identification.solving.posterior import exact
from lagrangian_ff.identification.solving.solution import LeftOut
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.kernels import States, threads
from lagrangian_ff.kernels.structured.chain import Chain
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.sampling import usual_step

LOAD_SECONDS = 2.0
"""Length of the blocks that the load is predicted without."""
MANY = 64
"""Number of columns of a joint above which its response saves time."""
ROWS_AT_ONCE = 480
AVERAGED = 0.07  # s, over which samples are averaged at most


@dataclass(frozen=True)
class Whitened:
    """A whitened motion.

    Attributes:
        motion: the whole motion.
        index: (S,) the samples used.  seconds: length of the blocks of time that are independent.
        inputs: the whole motion as effects read it.
        problem: of the samples used: a serial arm of unknown masses with white noise on every
            joint, the effects already in the model with free parameters, and nuisance columns.
        system: the factored system.
        residual: (S N,) whitened, of variance one if nothing is missing.
        explained: (S N, B) orthonormal whitened columns of everything explained.
        lagging: whether a lag of the torques is among that.
    """

    motion: Motion
    index: Ints
    seconds: float
    inputs: Inputs
    problem: Problem
    system: System
    residual: Floats
    explained: Floats
    lagging: bool = False

    @property
    def x(self) -> Inputs:
        """Return the samples used, as effects read them."""
        return self.problem.samples.x

    @property
    def basis(self) -> Basis:
        """Return the effects already in the model."""
        return self.problem.basis

    @property
    def joints(self) -> int:
        """Return the number of joints N."""
        return len(self.motion.joints)

    @property
    def amplitude(self) -> float:
        """Return one standard deviation of the whitened residual, in units of the prior."""
        return float(np.sqrt(self.system.amplitude))

    @property
    def noise(self) -> Floats:
        """Return the standard deviation (N,) N·m of each joint's unexplained torque."""
        deviation = np.sqrt(self.problem.variances) * self.amplitude
        return np.asarray(deviation * self.problem.unit)

    @property
    def spread(self) -> Floats:
        """Return the standard deviation (N,) N·m of each joint's torque."""
        return np.asarray(np.std(self.motion.tau, axis=0))

    @cached_property
    def block(self) -> Ints:
        """Return (S,) the block of time of each sample used."""
        return np.asarray(self.motion.blocks(self.seconds)[self.index])

    @cached_property
    def starts(self) -> Ints:
        """Return the first row (B,) of each block among the S N whitened rows."""
        rows = np.repeat(self.block, self.joints)
        return np.asarray(np.flatnonzero(np.diff(rows, prepend=-1)), dtype=np.int64)

    @cached_property
    def _responses(self) -> dict[int, Floats]:
        return {}

    def response(self, joint: int) -> Floats:
        """Return the whitened unit torques (S, S N) of one joint; zero before each sample.

        With them, many columns of a joint cost a third of a triangular solve each. The responses
        of two joints are kept, for two threads.
        """
        found = self._responses.get(joint)
        if found is None:
            found = _response(self.system.upper, self.joints, joint)
            for oldest in list(self._responses)[:-1]:
                self._responses.pop(oldest, None)
            self._responses[joint] = found
        return found

    def forget(self) -> None:
        """Free the memory that `response` keeps."""
        self._responses.clear()

    def assuming(self, other: Problem) -> "Whitened":
        """Return the same motion with the kernel, noise, units and change of another problem.

        The factor is reused if they are the same objects.
        """
        mine = self.problem
        same = mine.change is other.change and all(
            getattr(mine.prior, name) is getattr(other.prior, name)
            for name in ("kernel", "noise", "scaling")
        )
        prior = replace(other.prior, basis=mine.basis)
        problem = replace(mine, prior=prior, change=other.change)
        return self._again(problem, self.system if same else None)

    def explaining(self, basis: Basis, nuisance: tuple[Nuisance, ...]) -> "Whitened":
        """Return the same motion with other effects and columns explained, with the same factor."""
        problem = replace(self.problem.having(basis=basis), nuisance=nuisance)
        return self._again(problem, self.system)

    def _again(self, problem: Problem, like: System | None) -> "Whitened":
        parts = self.motion, self.index, self.seconds, self.inputs
        weight = problem.samples.weight
        return whiten(*parts, problem, self.x, like, weight, lagging=self.lagging)

    def whitened(self, columns: Floats, joint: int, *, coarse: bool = False) -> Floats:
        """Return columns of one joint's torque whitened, (S N, K), without projection.

        Args:
            columns: (S, K) N·m.
            coarse: whether many columns at once come in single precision, which is twice as fast
                and exact enough to choose by.
        """
        samples, count = columns.shape
        scaled = np.asarray(columns.T) / (self.problem.unit[joint] * self.amplitude)
        if count >= MANY or joint in self._responses:
            return _multiplied(scaled, self.response(joint), coarse=coarse)
        full = np.zeros((count, samples, self.joints))
        full[:, :, joint] = scaled
        flat = full.reshape(count, -1).T
        return np.asarray(
            solve_triangular(self.system.upper, flat, trans=1, check_finite=False, overwrite_b=True)
        )

    def shared(self, columns: Floats, on: Floats) -> Floats:
        """Return columns (S, K) N·m whitened, (S N, K), that act on several joints.

        Args:
            on: (K, N) the factor of each in the torque of each joint.
        """
        full = columns[:, None, :] * (on / self.problem.unit).T / self.amplitude
        flat = np.asfortranarray(full.reshape(-1, columns.shape[1]))
        return np.asarray(
            solve_triangular(self.system.upper, flat, trans=1, check_finite=False, overwrite_b=True)
        )

    def late(self) -> Floats:
        """Return the whitened torque (S N,) of a lag of one second, to first order."""
        return error_of_lag(self.problem, self.system.upper) / self.amplitude

    def project(self, whitened: Floats) -> Floats:
        """Return whitened columns (S N, K) with everything explained projected out."""
        return np.asarray(whitened - self.explained @ (self.explained.T @ whitened))

    def inputs_of(self, motion: Motion) -> Inputs:
        """Return any motion of these joints as effects read it, with load and torque predicted.

        The load goes through the gear: it excludes the rotors' inertia and includes constant
        torques, which are gravity over a part of the range.
        """
        x = States.of(motion.q, motion.qd, motion.qdd)
        speed = self.basis.sign_speed(self.joints)
        inputs = Inputs.of(x, motion.time, motion.segment, None, None, speed, motion.temperature)
        load, torque = self._predicted(inputs, self.system.weights, self.system.coefficients)
        return replace(inputs, load=load, torque=torque, rotor=self._rotor)

    @property
    def _rotor(self) -> Floats:
        return rotor(self.problem, self.system.weights.reshape(len(self.index), self.joints))

    def inputs_left_out(self) -> Inputs:
        """Return the samples used, and the motion behind them, with the load cross-validated.

        The load at each moment is predicted without `LOAD_SECONDS` about that moment: a load fitted
        to the torque that it is to explain would contain the answer.
        """
        block = self.motion.blocks(LOAD_SECONDS)[self.index]
        _, place = np.unique(block, return_inverse=True)
        ends = np.flatnonzero(np.diff(place, prepend=-1, append=-1)) * self.joints
        left = _left_out(self.system, ends.tolist())
        weights = self.system.weights_without(left)
        between = 0.5 * (self.index[1:] + self.index[:-1])
        nearest = place[np.searchsorted(between, np.arange(len(self.inputs)))]
        load, torque = np.zeros((2, *self.inputs.q.shape))

        def predict(number: int) -> None:
            here = np.flatnonzero(nearest == number)
            x = self.inputs.take(here)
            coefficients = self.system.coefficients + left[number].change
            load[here], torque[here] = self._predicted(x, weights[:, number], coefficients)

        threads.side_by_side(predict, range(len(left)))
        whole = replace(self.inputs, load=load, torque=torque, rotor=self._rotor)
        return whole.take(self.index, self.x.window)

    def _predicted(self, x: Inputs, weights: Floats, coefficients: Floats) -> tuple[Floats, Floats]:
        """Return load and whole torque, (M, N) N·m each, for weights (S N,) and coefficients."""
        by_joint = weights.reshape(len(self.index), self.joints)
        load = rigid_torque(self.problem, x, by_joint)
        load += self.basis.constant(self.joints, coefficients)
        rotors = x.qdd * rotor(self.problem, by_joint)
        x = replace(x, load=load, torque=load)
        return load, load + rotors + self.basis.beside_load(x, coefficients)


def window_of(index: Ints, motion: Motion) -> int:
    """Return the number of samples averaged about each of those used: at most all between them.

    Averaging lowers the noise. Over more than `AVERAGED` s it would damp vibrations of some Hz too.
    """
    if len(index) < 2:
        return 1
    step = usual_step(motion.time)
    most = min(float(np.median(np.diff(index))), AVERAGED / step)
    return max(1, 2 * int((most + 1e-6 - 1.0) // 2) + 1)


def whiten(
    motion: Motion,
    index: Ints,
    seconds: float,
    inputs: Inputs,
    assumed: Problem,
    x: Inputs | None = None,
    like: System | None = None,
    weight: Floats | None = None,
    *,
    lagging: bool = False,
) -> Whitened:
    """Return a motion factored and whitened, with the tangents of the basis' shapes explained too.

    Args:
        motion, index, seconds, inputs: see `Whitened`.
        assumed: the problem; its samples are replaced.
        x: the samples used; None takes them from the inputs.
        like: a system of the same samples, kernel, noise and weights, whose factor is reused.
        weight: (S, N) by how much the noise of each torque is divided; None is 1.
        lagging: whether a lag of the torques is explained, too.

    Raises:
        NotPositiveDefiniteError: the noise is too small for the arithmetic.
    """
    x = x or inputs.take(index, window_of(index, motion))
    problem = assumed.of(Samples(x, x.mean(motion.tau), weight=weight))
    tangents = (*problem.nuisance, *errors_of_shapes(problem.basis, x))
    system = exact(replace(problem, nuisance=tangents), like=like).system
    columns = system.white_design
    if lagging:
        columns = np.column_stack([columns, error_of_lag(problem, system.upper)])
    explained, triangle = np.linalg.qr(columns)
    weak = np.abs(np.diag(triangle)) < 1e-9 * np.abs(triangle).max(initial=0.0)
    explained = explained[:, ~weak]
    white = system.white_target - explained @ (explained.T @ system.white_target)
    residual = white / np.sqrt(system.amplitude)
    return Whitened(motion, index, seconds, inputs, problem, system, residual, explained, lagging)


def rigid_torque(problem: Problem, x: Inputs, weights: Floats) -> Floats:
    """Return the rigid-body torque (M, N) N·m without the rotors, for weights (S, N)."""
    kernel = chain_of(problem).replace(rotor=np.zeros(x.joints))
    at, centres = States(x.q, x.qd, x.qdd), problem.samples
    torque = kernel.learned(centres.states, weights).torque(at)
    if problem.change is not None:
        inside = weights * within(problem.change, centres.x)[:, None]
        added = kernel.learned(centres.states, inside).torque(at)
        torque += problem.change[2] * added * within(problem.change, x)[:, None]
    return np.asarray(torque * problem.unit)


def rotor(problem: Problem, weights: Floats) -> Floats:
    """Return the rotors' inertia (N,) kg·m², for weights (S, N)."""
    kernel = chain_of(problem)
    own = kernel.rotor * kernel.inertia**2
    return np.asarray(own * np.sum(problem.samples.x.qdd * weights, axis=0) * problem.unit)


def chain_of(problem: Problem) -> Chain:
    """Return the kernel of a serial arm."""
    assert isinstance(problem.kernel, Chain)
    return problem.kernel


def _left_out(system: System, ends: Sequence[int]) -> list[LeftOut]:
    """Return `System.left_out` for contiguous blocks of rows that `ends` delimits.

    Only the rows of U⁻¹ of one block are in memory at a time.
    """
    white = solve_triangular(system.upper, system.white_design, check_finite=False)

    def without(rows: tuple[int, int]) -> LeftOut:
        first, last = rows
        half = inverse_rows(system.upper, first, last)
        mine = white[first:last]
        projected = half @ half.T - mine @ system.covariance @ mine.T
        residual = np.linalg.solve(projected, system.weights[first:last])
        change = -system.covariance @ (mine.T @ residual)
        return LeftOut(np.arange(first, last), residual, change)

    system.covariance  # noqa: B018  computed once, before the threads read it
    return threads.side_by_side(without, pairwise(ends))


def inverse_rows(upper: Floats, first: int, last: int) -> Floats:
    """Return rows of U⁻¹ (R, n - first), from where they are not zero."""
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
    """Return the rows (S, S N) of U⁻¹ of one joint, block by block, skipping zeros."""
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
        solved = solve_triangular(corner, out[known, here].T, trans=1, check_finite=False)
        out[known, here] = solved.T
    return out


def _multiplied(columns: Floats, response: Floats, *, coarse: bool) -> Floats:
    """Return the columns (K, S) whitened, (S N, K), skipping zeros of the response."""
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
    """Return the number of samples that the first `rows` rows belong to."""
    return -(-rows // joints)
