"""Bursts of a model's residual, in parts of what the model's own errors give there.

Filters of several lengths take the mean of a window minus that of its two neighbours, each as
long. What a model that is nearly right gives is not one number: masses that are a little wrong err
with what speed, acceleration and gravity change meanwhile, a delay with the slope of the torque,
friction about reversals and in creeping. Each is a component of the variance, learned from the
model's training motion. What the model says it does not know, and friction in creeping, come on
top.
"""

from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.diagnosis.compare import OUTSIDE
from lagrangian_ff.identification import Model
from lagrangian_ff.kernels import States
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.sampling import usual_step

LENGTHS = 0.06 * 2.0 ** np.arange(5)  # s
BLOCK = 1.0  # s, of which the largest output counts
FEWEST = 20
"""Windows of a filter, end to end, without which its usual outputs are unknown."""
SPARSE = 8
"""Samples from one to the next at which the model says how sure it is."""
STEPS = 30
"""Of the climb to the likeliest components of the variance."""
MEDIAN = 0.6745
"""Of the absolute value of a normal variable."""
CREEP = 0.1
"""Share of a joint's rms speed below which friction may have any form."""
AFTER = 0.1
"""s after a reversal in which friction settles."""


@dataclass(frozen=True)
class Scan:
    """The outputs of the filters along a motion.

    Attributes:
        motion: M samples of N joints.
        residual: (M, N) N·m, measured minus predicted.
        counts: (F,) samples of each filter's window.
        output: (F, M, N) N·m.
        scale: (F, M, N) N·m that the model's errors are expected to give there; infinite where
            nothing can be said: at rest, outside the range that the model knows, and where a
            window does not fit.
    """

    motion: Motion
    residual: Floats
    counts: Ints
    output: Floats
    scale: Floats

    @property
    def z(self) -> Floats:
        """Return (F, M, N) the outputs in parts of what is expected, without sign."""
        return np.abs(self.output) / self.scale

    def largest(self, z: Floats) -> Floats:
        """Return the largest of `z` in each block, where there is any."""
        starts = np.unique(self.motion.blocks(BLOCK), return_index=True)[1]
        found = np.maximum.reduceat(z.max(axis=(0, 2)), starts)
        return np.asarray(found[found > 0.0])


@dataclass(frozen=True)
class Filters:
    """The filters, and what a model's errors give in them.

    Attributes:
        model: N joints.
        parts: by filter, (K, N) the variances of K components in its training motion; infinite
            where there is too little of that.
        usual: the scan of the training motion.
    """

    model: Model
    parts: tuple[Floats, ...]
    usual: Scan

    @classmethod
    def of(cls, model: Model, learned: Motion) -> "Filters":
        """Return those of a model, from motion that it learned from."""
        sources = _Sources.of(model, learned)
        seen = [sources.filtered(length) for length in LENGTHS]
        parts = tuple(_components(one) for one in seen)
        return cls(model, parts, _scan(sources, seen, parts))

    def scan(self, motion: Motion) -> Scan:
        """Return the scan of a motion.

        Where its outputs are larger than expected in the median, they all count as much larger.
        """
        sources = _Sources.of(self.model, motion)
        return _scan(sources, [sources.filtered(length) for length in LENGTHS], self.parts, True)


@dataclass(frozen=True)
class _Filtered:
    """The output of a filter along a motion.

    Attributes:
        count: samples of its window.
        output: (M, N) N·m, of the residual.
        shares: (M, K, N) what each component of the variance may have there.
        unknown: (M, N) (N·m)², variance that is not learned.
        valid: (M, N) where the output counts.
    """

    count: int
    output: Floats
    shares: Floats
    unknown: Floats
    valid: Flags


@dataclass(frozen=True)
class _Sources:
    """The causes of the model's errors along a motion; arrays are (M, N).

    Attributes:
        motion: M samples.  residual: N·m.
        changes: what the model errs with as it changes: acceleration, squared speed and position in
            parts of the training motion's, torque, its slope, direction, and that in creeping.
        amounts: what it errs with as it is there: speed, acceleration, friction that settles, and
            creeping.
        unknown: (N·m)², the variance that the data left to the model.
        creeping: N·m, friction in creeping.
        valid: whether the joint moves, inside the range that the model knows.
    """

    motion: Motion
    residual: Floats
    changes: tuple[Floats, ...]
    amounts: tuple[Floats, ...]
    unknown: Floats
    creeping: Floats
    valid: Flags

    @classmethod
    def of(cls, model: Model, x: Motion) -> "_Sources":
        """Return those of a motion."""
        known = model.data
        speed, hardness, width = (
            _rms(one) for one in (known.qd, known.qdd, known.q - known.q.mean(axis=0))
        )
        predicted = model.torque(model.inputs_of(x))
        slope = np.gradient(predicted, usual_step(x.time, x.segment), axis=0)
        fast, hard, way = (x.qd / speed) ** 2, x.qdd / hardness, np.sign(x.qd)
        creep = np.exp(-fast / CREEP**2)
        inside = model.range.excess(States(x.q, x.qd, x.qdd)).max(axis=1) <= OUTSIDE
        return cls(
            motion=x,
            residual=x.tau - predicted,
            changes=(hard, fast, x.q / width, predicted, slope, way, way * creep),
            amounts=(fast, hard**2, _settling(x), creep),
            unknown=_unknown(model, x),
            creeping=creep * _coulomb(model),
            valid=inside[:, None] & ~x.rest,
        )

    def filtered(self, length: float) -> _Filtered:
        """Return what a filter of this length, s, makes of the motion."""
        time, segment = self.motion.time, self.motion.segment
        step = usual_step(time, segment)
        half = max(1, round(0.5 * (length / step - 1.0)))
        count = 2 * half + 1
        reach = half + count
        squares = [_contrast(one, half, reach) ** 2 for one in self.changes]
        amounts = [_mean(one, reach) for one in self.amounts]
        shares = [np.ones_like(self.residual), *squares, *amounts]
        if self.residual.shape[1] > 1:
            # Acceleration, speed, position and reversals of the other joints.
            others = (*squares[:3], squares[5], amounts[1], amounts[2])
            shares += [one.sum(axis=1, keepdims=True) - one for one in others]
        first, last = _ends(len(time), reach)
        whole = (last - first == 2 * reach) & (segment[first] == segment[last])
        whole &= time[last] - time[first] < 1.1 * 2 * reach * step
        return _Filtered(
            count,
            _contrast(self.residual, half, reach),
            np.stack(shares, axis=1),
            _mean(self.unknown, reach) + _contrast(self.creeping, half, reach) ** 2,
            whole[:, None] & (_mean(~self.valid, reach) < 0.5 / (2 * reach + 1)),
        )


def _unknown(model: Model, x: Motion) -> Floats:
    """Return (M, N) (N·m)² that the data left to the model, interpolated between some samples."""
    number = np.arange(len(x))
    at = np.unique(np.append(number[::SPARSE], number[-1]))
    some = model.quick_uncertainty.variance(
        x.q, x.qd, x.qdd, time=x.time, segment=x.segment, noise=False, at=at
    )
    return np.stack([np.interp(number, at, one) for one in some.T], axis=1)


def _coulomb(model: Model) -> Floats:
    """Return (N,) N·m, the Coulomb friction of each joint as the model has it."""
    found = np.zeros(len(model.joints))
    for term, place in model.basis.slices():
        if term.effect.name == "coulomb":
            found[term.joint] = abs(float(model.coefficients[place][0]))
    return found


def _settling(x: Motion) -> Floats:
    """Return (M, N) how much each joint's friction still settles from its last reversal, 0 to 1."""
    turned = np.zeros(x.q.shape, dtype=bool)
    turned[1:] = np.signbit(x.qd[1:]) != np.signbit(x.qd[:-1])
    last = np.maximum.accumulate(np.where(turned, np.arange(len(x))[:, None], -1), axis=0)
    since = x.time[:, None] - x.time[np.maximum(last, 0)]
    return np.where(last >= 0, np.exp(-np.maximum(since, 0.0) / AFTER), 0.0)


def _rms(values: Floats) -> Floats:
    return np.asarray(np.maximum(np.sqrt(np.mean(values**2, axis=0)), 1e-9))


def _ends(samples: int, reach: int) -> tuple[Ints, Ints]:
    number = np.arange(samples)
    return np.maximum(number - reach, 0), np.minimum(number + reach, samples - 1)


def _mean(values: "Floats | Flags", reach: int) -> Floats:
    """Return (M, N) the mean of `reach` samples to both sides, fewer at the ends."""
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)])
    first, last = _ends(len(values), reach)
    return np.asarray((total[last + 1] - total[first]) / (last + 1 - first)[:, None])


def _contrast(values: Floats, half: int, reach: int) -> Floats:
    """Return (M, N) the mean of a window minus that of the two beside it."""
    return 1.5 * (_mean(values, half) - _mean(values, reach))


def _components(seen: _Filtered) -> Floats:
    """Return (K, N) the likeliest variances of the components of what a filter sees.

    The multiplicative steps are those of Févotte, Bertin and Durrieu 2009, Neural Computation 21.
    """
    _, components, joints = seen.shares.shape
    found = np.full((components, joints), np.inf)
    for n in range(joints):
        rows = np.flatnonzero(seen.valid[:, n])
        if len(rows) < FEWEST * 3 * seen.count:
            continue
        rows = rows[:: max(1, seen.count // 3)]
        shares, square = seen.shares[rows, :, n], seen.output[rows, n] ** 2
        mean = np.maximum(shares.mean(axis=0), 1e-100)
        shares = shares / mean
        part = np.full(len(mean), max(float(square.mean()), 1e-24) / len(mean))
        for _ in range(STEPS):
            variance = shares @ part
            less = np.maximum((1.0 / variance) @ shares, 1e-100)
            part = part * ((square / variance**2) @ shares) / less
        found[:, n] = part / mean
    return found


def _scan(
    sources: _Sources, seen: list[_Filtered], parts: tuple[Floats, ...], calm: bool = False
) -> Scan:
    """Return the scan of a motion; `calm` makes its median output the one that is expected."""
    scales = []
    for one, part in zip(seen, parts, strict=True):
        scale = np.full(one.output.shape, np.inf)
        for n in np.flatnonzero(np.isfinite(part).all(axis=0)):
            at = one.valid[:, n]
            if not at.any():
                continue
            expected = np.sqrt(one.shares[at, :, n] @ part[:, n] + one.unknown[at, n])
            if calm:
                middle = float(np.median(np.abs(one.output[at, n]) / expected))
                expected *= max(middle / MEDIAN, 1.0)
            scale[at, n] = expected
        scales.append(scale)
    counts = np.array([one.count for one in seen])
    output = np.stack([one.output for one in seen])
    return Scan(sources.motion, sources.residual, counts, output, np.stack(scales))
