"""The inputs of an effect: the motion, its time, and the model's torque."""

from collections.abc import Hashable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.effects.reversals import since_reversal
from lagrangian_ff.kernels.states import States
from lagrangian_ff.recording.rest import at_rest
from lagrangian_ff.sampling import stretches

SIGN_SPEED = 0.02  # rad/s, width of the smoothed sign unless the model has found a better one
LONG_AGO = 10.0  # s since a reversal, after which more makes no difference
AVERAGED = ("q", "qd", "qdd", "load", "torque")


@dataclass(frozen=True)
class Inputs:
    """A motion as effects see it, without the measured torque: that holds the answer.

    Attributes:
        q: (M, N) rad.  qd: (M, N) rad/s.  qdd: (M, N) rad/s².
        time: (M,) s since the recording began; infinite if unknown: everything has settled then.
        segment: (M,) samples recorded without interruption share a number.
        load: (M, N) N·m, the model's rigid-body torque through the gear.
        torque: (M, N) N·m, all that the model predicts without the effect.
        sign_speed: (N,) rad/s, v0 of the smoothed sign tanh(qd / v0).
        whole: the uninterrupted motion that these samples come from; None if they are it.
        index: (M,) where in `whole` they lie.
        rotor: (N,) kg·m², the inertia before the gears that is not counted into `load`.
        temperature: (M, N) °C, NaN where it was not measured; None if none was.
        window: samples of `whole` about its place that each sample is the mean of, an odd number.
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
    temperature: Floats | None = None

    @classmethod
    def of(
        cls,
        states: States,
        time: ArrayLike | None = None,
        segment: Ints | None = None,
        load: Floats | None = None,
        torque: Floats | None = None,
        sign_speed: Floats | None = None,
        temperature: Floats | None = None,
    ) -> "Inputs":
        """Return the inputs of some states; what is not given is settled, or zero.

        Without time every sample stands alone: it has no past and no rate of change.
        """
        count, joints = states.q.shape
        zero = np.zeros_like(states.q)
        if segment is None:
            segment = np.arange(count) if time is None else np.zeros(count, dtype=np.int64)
        when = np.full(count, np.inf) if time is None else np.asarray(time, dtype=np.float64)
        load, torque = (zero if one is None else one for one in (load, torque))
        width = np.full(joints, SIGN_SPEED) if sign_speed is None else sign_speed
        motion = states.q, states.qd, states.qdd, when, segment
        return cls(*motion, load, torque, width, np.zeros(joints), temperature=temperature)

    def __len__(self) -> int:
        return int(self.q.shape[0])

    @property
    def joints(self) -> int:
        """Return the number of joints N."""
        return int(self.q.shape[1])

    def take(self, index: Ints, window: int = 1) -> "Inputs":
        """Return some of the samples; effects with a memory still see all of them.

        Args:
            index: of the samples.
            window: how many samples about each place to average, of an uninterrupted motion only;
                samples that were taken from one already stay as they are.
        """
        origin = index if self.index is None else self.index[index]
        window = window if self.whole is None else self.window
        part = {name: getattr(self, name)[index] for name in (*AVERAGED, "time", "segment")}
        if self.temperature is not None:  # slow: no mean is needed
            part["temperature"] = self.temperature[index]
        some = replace(self, **part, whole=self.whole or self, index=origin, window=window)
        if self.whole is not None or window == 1:
            return some
        means: dict[str, Any] = {name: some.mean(getattr(self, name)) for name in AVERAGED}
        return replace(some, **means)

    def mean(self, values: Floats) -> Floats:
        """Return (M, ...) values (W, ...) of the whole motion at these samples, averaged likewise.

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
        """Return the operator (M, W) that averages values of the whole motion about each sample."""
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

    @cached_property
    def rest(self) -> Flags:
        """Return (M, N) where each joint stands still, at least for a part of what is averaged."""
        if self.whole is None:
            return at_rest(self.time, self.q, self.segment)
        return self.mean(self.whole.rest.astype(np.float64)) > 0.0

    def sign(self, joint: int) -> Floats:
        """Return (M,) the smoothed sign of one joint's velocity, tanh(qd / v0)."""
        return np.asarray(np.tanh(self.qd[:, joint] / self.sign_speed[joint]))

    def temperature_of(self, joint: int) -> Floats:
        """Return (M,) °C of a joint; NaN where it was not measured."""
        if self.temperature is None:
            return np.full(len(self), np.nan)
        return np.asarray(self.temperature[:, joint])

    def rate(self, values: Floats) -> Floats:
        """Return (M, ...) the rate of change of values (M, ...), per s; never across a segment."""
        out = np.zeros_like(values)
        for piece in self.pieces():
            if piece.stop - piece.start > 1 and np.isfinite(self.time[piece.start]):
                out[piece] = np.gradient(values[piece], self.time[piece], axis=0)
        return out

    def since_reversal(self, joint: int) -> Floats:
        """Return (M,) s since a joint last turned round, or its stretch began; `LONG_AGO` at most.

        Also `LONG_AGO` where nothing is known of time. The slowest reversal counts: friction turns
        over with it.
        """
        whole = self.whole or self
        since = np.full(len(whole), LONG_AGO)
        if np.isfinite(whole.time).all():
            since = since_reversal(whole.time, whole.qd[:, joint], whole.segment, rest=0.0)
            for piece in whole.pieces():
                time = whole.time[piece]
                since[piece] = np.where(np.isnan(since[piece]), time - time[0], since[piece])
        since = np.minimum(since, LONG_AGO)
        return since if self.index is None else since[self.index]

    def step(self, piece: slice) -> float:
        """Return s between the samples of an uninterrupted stretch; 0 without time."""
        time = self.time[piece]
        if len(time) < 2 or not np.isfinite(time[0]):
            return 0.0
        # Rounded, so that a step does not depend on the last digit of a clock.
        return round(float(np.median(np.diff(time))), 9)

    @cached_property
    def kept(self) -> dict[Hashable, Floats]:
        """Return the columns that effects keep, which are expensive and needed again."""
        return {}

    def pieces(self) -> list[slice]:
        """Return the uninterrupted stretches, in order."""
        return self._pieces

    @cached_property
    def _pieces(self) -> list[slice]:
        return [slice(begin, end) for begin, end in stretches(self.segment)]
