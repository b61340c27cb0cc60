"""What an effect may look at: the motion, its time, and what the model says of the torque."""

from collections.abc import Hashable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from lagrangian_ff.kernels.states import States

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SIGN_SPEED = 0.02  # rad/s, where the smoothed sign turns over unless the model has found better


@dataclass(frozen=True)
class Inputs:
    """A motion as effects see it. Never the measured torque: it holds the answer.

    Attributes:
        q: (M, N) rad.  qd: (M, N) rad/s.  qdd: (M, N) rad/s².
        time: (M,) s since the recording began; infinite where nothing is known of time, which
            means long after everything has settled.
        segment: (M,) samples recorded without interruption share a number.
        load: (M, N) N·m, the model's rigid-body torque through the gear.
        torque: (M, N) N·m, all that the model predicts without the effect.
        sign_speed: (N,) rad/s, v0 of the smoothed sign tanh(qd / v0).
        whole: the uninterrupted motion that these samples were taken from; None: they are it.
        index: (M,) where in `whole` they lie.
        rotor: (N,) kg·m², the inertia before the gears that is not counted into `load`.
        window: each sample is the mean of so many of `whole` about its place, an odd number.
    """

    q: Floats
    qd: Floats
    qdd: Floats
    time: Floats
    segment: Ints
    load: Floats
    torque: Floats
    sign_speed: Floats
    rotor: Floats
    whole: "Inputs | None" = None
    index: Ints | None = None
    window: int = 1

    @classmethod
    def of(
        cls,
        states: States,
        time: ArrayLike | None = None,
        segment: Ints | None = None,
        load: Floats | None = None,
        torque: Floats | None = None,
        sign_speed: Floats | None = None,
    ) -> "Inputs":
        """What is known of some states; what is not given is taken to be settled, or zero.

        Without time every sample stands alone: it has no past and no rate of change.
        """
        count, joints = states.q.shape
        zero = np.zeros_like(states.q)
        if segment is None:
            segment = np.arange(count) if time is None else np.zeros(count, dtype=np.int64)
        return cls(
            states.q,
            states.qd,
            states.qdd,
            np.full(count, np.inf) if time is None else np.asarray(time, dtype=np.float64),
            segment,
            zero if load is None else load,
            zero if torque is None else torque,
            np.full(joints, SIGN_SPEED) if sign_speed is None else sign_speed,
            np.zeros(joints),
        )

    def __len__(self) -> int:
        return int(self.q.shape[0])

    @property
    def joints(self) -> int:
        """The number of joints N."""
        return int(self.q.shape[1])

    def take(self, index: Ints, window: int = 1) -> "Inputs":
        """Some of the samples; what has a memory still sees all of them.

        Args:
            index: which.
            window: the mean of so many samples about each place is taken, of an uninterrupted
                motion only; samples that were taken from one already stay what they are.
        """
        origin = index if self.index is None else self.index[index]
        some = Inputs(
            self.q[index],
            self.qd[index],
            self.qdd[index],
            self.time[index],
            self.segment[index],
            self.load[index],
            self.torque[index],
            self.sign_speed,
            self.rotor,
            self.whole or self,
            origin,
            window if self.whole is None else self.window,
        )
        if self.whole is not None or window == 1:
            return some
        return replace(
            some,
            q=some.mean(self.q),
            qd=some.mean(self.qd),
            qdd=some.mean(self.qdd),
            load=some.mean(self.load),
            torque=some.mean(self.torque),
        )

    def mean(self, values: Floats) -> Floats:
        """(M, ...) values (W, ...) of the whole motion where these samples are, averaged as they.

        A mean never reaches across a segment.
        """
        if self.whole is None or self.index is None:
            return values
        if self.window == 1:
            return np.asarray(values[self.index])
        flat = self._averages @ values.reshape(len(values), -1)
        return np.asarray(flat.reshape(-1, *values.shape[1:]))

    @cached_property
    def _averages(self) -> "scipy.sparse.csr_array":
        """(M, W) what takes the mean of values of the whole motion about each sample."""
        assert self.whole is not None
        assert self.index is not None
        segment, half = self.whole.segment, self.window // 2
        bounds = np.concatenate([[0], np.flatnonzero(np.diff(segment)) + 1, [len(segment)]])
        piece = np.searchsorted(bounds, self.index, side="right")
        first = np.maximum(self.index - half, bounds[piece - 1])
        count = np.minimum(self.index + half + 1, bounds[piece]) - first
        ends = np.concatenate([[0], np.cumsum(count)])
        places = np.arange(ends[-1]) + np.repeat(first - ends[:-1], count)
        return scipy.sparse.csr_array(
            (np.repeat(1.0 / count, count), places, ends), (len(self), len(segment))
        )

    def sign(self, joint: int) -> Floats:
        """(M,) the smoothed sign of one joint's velocity, tanh(qd / v0)."""
        return np.asarray(np.tanh(self.qd[:, joint] / self.sign_speed[joint]))

    def rate(self, values: Floats) -> Floats:
        """(M, ...) the change of values (M, ...) with time, per s; never across a segment."""
        out = np.zeros_like(values)
        for piece in self.pieces():
            if piece.stop - piece.start > 1 and np.isfinite(self.time[piece.start]):
                out[piece] = np.gradient(values[piece], self.time[piece], axis=0)
        return out

    def step(self, piece: slice) -> float:
        """s between the samples of an uninterrupted stretch; 0 where nothing is known of time."""
        time = self.time[piece]
        if len(time) < 2 or not np.isfinite(time[0]):
            return 0.0
        # Rounded, so that a step does not depend on the last digit of a clock.
        return round(float(np.median(np.diff(time))), 9)

    @cached_property
    def kept(self) -> dict[Hashable, Floats]:
        """What effects keep that is dear to make and asked for again."""
        return {}

    def pieces(self) -> list[slice]:
        """The uninterrupted stretches, in order."""
        return self._pieces

    @cached_property
    def _pieces(self) -> list[slice]:
        ends = np.flatnonzero(np.diff(self.segment)) + 1
        bounds = [0, *ends.tolist(), len(self)]
        return [slice(a, b) for a, b in pairwise(bounds) if b > a]
