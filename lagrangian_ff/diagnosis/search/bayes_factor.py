"""The log Bayes factor of a candidate, with noise that may be correlated in time.

Let w be the whitened residual and Z the candidate's whitened columns, with what is known projected
out. The prior of its parameters is a torque of 0.3 of the joint's spread. Its log Bayes factor is

    ½ cᵀ (A + I)⁻¹ c − ½ log |A + I|,   A = ZᵀZ / f,   c = Zᵀw / f.

The variance inflation f ≥ 1 tempers the likelihood: it is the variance of the sums over blocks of
time, after the candidate is subtracted, relative to that of white noise. Samples that err alike
thus count as few independent blocks, not as many samples.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.diagnosis.whitening import Whitened
from lagrangian_ff.identification.problem import Nuisance
from lagrangian_ff.kernels import threads

PRIOR_SHARE = 0.3
"""Standard deviation of an effect's torque a priori, relative to the joint's spread."""
COLUMNS_AT_ONCE = 256
MANY = 64
"""Number of candidates above which a second thread saves time."""
ROUNDS, POINTS = 3, 5
"""Rounds in which a shape is refined, and values tried in each."""
LOOKS, NEAR = 120, 0.5
"""Shapes that are looked at where all are moved at once, and steps of their grid to begin with."""


@dataclass(frozen=True)
class BayesFactor:
    """A candidate compared with the residual.

    Attributes:
        log_bf: of the candidate, nats, tempered.  variance_inflation: f.
        survival: the share of its whitened columns that remains after projection, 0 to 1.
        coefficients: (P,) its parameters, in their units.
        size: N·m, root mean square of its torque on the samples used.
        blocks: (B, P) sums over blocks of scaled columns times residual.
        information: (P, P) A without f.
        likelihood: (B,) nats by block of the log likelihood ratio, not tempered.
    """

    candidate: Candidate
    log_bf: float
    variance_inflation: float
    survival: float
    coefficients: Floats
    size: float
    blocks: Floats
    information: Floats
    likelihood: Floats

    def tempered(self, variance_inflation: float) -> float:
        """Return the log Bayes factor, nats, with another f."""
        sums = self.blocks.sum(axis=0)[None]
        return float(tempered_log_bf(sums, self.information, variance_inflation)[0])

    @property
    def once(self) -> bool:
        """Return whether it is an event, which happens once, in a few blocks."""
        return self.candidate.named and self.candidate.effect.kind == "event"

    def expected_gain(self, size: float) -> float:
        """Return the mean log Bayes factor, nats, where the candidate is there.

        Args:
            size: share of the joint's torque that it has.
        """
        signal, price = self._signal_and_price
        return 0.5 * (signal * size**2 - price)

    def least_size(self, gain: float) -> float:
        """Return the share of the joint's torque from which on `gain` nats are expected.

        It is infinite where everything known explains the candidate.
        """
        signal, price = self._signal_and_price
        return float(np.sqrt((2.0 * gain + price) / signal)) if signal > 0.0 else np.inf

    @property
    def _signal_and_price(self) -> tuple[float, float]:
        """Return twice the nats that it brings at the size of the joint's torque, and costs."""
        information = self.information / self.variance_inflation
        signal = float(np.trace(information)) / len(information) / PRIOR_SHARE**2
        return signal, float(np.linalg.slogdet(np.eye(len(information)) + information)[1])


def tempered_log_bf(
    sums: Floats, information: Floats, variance_inflation: Floats | float
) -> Floats:
    """Return ½ cᵀ (A + I)⁻¹ c − ½ log |A + I|, (..., R) nats.

    Args:
        sums: (..., R, P) c times f.  information: (..., P, P) A times f.
        variance_inflation: (...) f.
    """
    f = np.asarray(variance_inflation)[..., None, None]
    matrix = np.eye(information.shape[-1]) + information / f
    c = sums / f
    squares = np.sum(c @ np.linalg.inv(matrix) * c, axis=-1)
    return np.asarray(0.5 * squares - 0.5 * np.linalg.slogdet(matrix)[1][..., None])


def variance_inflation_of(rest: Floats, information: Floats | float) -> Floats:
    """Return f (...): by how much sums over blocks scatter more than noise does, 1 at least.

    Args:
        rest: (..., K) sums over blocks of columns times what is left, of all blocks and columns.
        information: (...) their variance if neighbouring samples are independent, the trace of A.
    """
    known = np.asarray(information)
    scatter = np.sum(rest**2, axis=-1) / np.where(known > 0.0, known, np.inf)
    return np.asarray(np.maximum(1.0, scatter))


def expected_log_bf(signal: float, information: Floats) -> float:
    """Return the mean log Bayes factor in nats of an effect that is there.

    Args:
        signal: mean of bᵀ A b over the coefficients b of the size in question.
        information: (P, P) A, tempered: it sets the price of the parameters.
    """
    return 0.5 * (signal - float(np.linalg.slogdet(np.eye(len(information)) + information)[1]))


def expected(columns: Floats, spread: float) -> Floats:
    """Return the prior standard deviation (P,) of the coefficients of columns (S, P).

    It corresponds to a torque of 0.3 of the joint's spread, N·m; it is 0 where a column is zero.
    """
    rms = np.sqrt(np.mean(columns**2, axis=0))
    return np.asarray(PRIOR_SHARE * spread / np.where(rms > 0.0, rms, np.inf))


def bayes_factors(
    whitened: Whitened, candidates: Sequence[Candidate], *, coarse: bool = False
) -> list[BayesFactor]:
    """Return the Bayes factors of candidates.

    Args:
        coarse: compute in single precision, for a first pass over many.

    Returns:
        Joint by joint, those of a joint in the order given.
    """
    parts = [[one for one in candidates if one.joint == joint] for joint in range(whitened.joints)]
    parts = [mine for mine in parts if mine]
    if len(candidates) < MANY:
        return [score for mine in parts for score in _of_joint(whitened, mine, coarse)]
    if len(parts) == 1:
        whitened.response(parts[0][0].joint)  # once, for both threads
        half = len(parts[0]) // 2
        parts = [parts[0][:half], parts[0][half:]]
    found = threads.side_by_side(lambda mine: _of_joint(whitened, mine, coarse), parts)
    return [score for some in found for score in some]


def _of_joint(
    whitened: Whitened, candidates: Sequence[Candidate], coarse: bool
) -> list[BayesFactor]:
    """Return the Bayes factors of candidates on one joint, in their order."""
    columns = [one.columns(whitened.x) for one in candidates]
    widths = np.array([one.shape[1] for one in columns])
    held: dict[int, BayesFactor] = {}
    for width in np.unique(widths).tolist():
        places = np.flatnonzero(widths == width)
        for first in range(0, len(places), max(1, COLUMNS_AT_ONCE // max(1, width))):
            some = places[first : first + max(1, COLUMNS_AT_ONCE // max(1, width))].tolist()
            raw = np.stack([columns[n] for n in some])
            made = _scored(whitened, [candidates[n] for n in some], raw, coarse)
            held.update(zip(some, made, strict=True))
    return [held[n] for n in range(len(candidates))]


def _scored(
    whitened: Whitened, candidates: Sequence[Candidate], raw: Floats, coarse: bool
) -> list[BayesFactor]:
    """Return the Bayes factors of candidates on one joint with columns `raw` (C, S, P)."""
    joint = candidates[0].joint
    count, samples, width = raw.shape
    flat = raw.transpose(1, 0, 2).reshape(samples, -1)
    scale = expected(flat, float(whitened.spread[joint]))
    white = whitened.whitened(flat * scale, joint, coarse=coarse).T
    elsewhere = np.zeros((len(white), whitened.joints))
    for number, candidate in enumerate(candidates):
        for other, factor in candidate.others.items():
            elsewhere[number * width : (number + 1) * width, other] = factor
    if elsewhere.any():
        both = np.flatnonzero(elsewhere.any(axis=1))
        white[both] += whitened.shared((flat * scale)[:, both], elsewhere[both]).T
    before = np.einsum("kn,kn->k", white, white)
    span = whitened.explained.astype(white.dtype)
    left = white - (white @ span) @ span.T
    after = np.einsum("kn,kn->k", left, left)
    # What remains is rounding where the known columns explain a column.
    left[after <= (1e-7 if coarse else 1e-10) * np.maximum(before, 1e-300)] = 0.0
    z, w = left.reshape(count, width, -1), whitened.residual.astype(white.dtype)
    information = (z @ z.swapaxes(1, 2)).astype(np.float64)
    blocks = _by_block(z * w, whitened)
    sums = blocks.sum(axis=2)
    found = np.linalg.solve(information + np.eye(width), sums[:, :, None])[:, :, 0]
    fitted = (found.astype(z.dtype)[:, None, :] @ z)[:, 0]
    likelihood = _by_block(fitted * (w - 0.5 * fitted), whitened)
    z *= fitted[:, None]
    rest = blocks - _by_block(z, whitened)
    trace = np.trace(information, axis1=1, axis2=2)
    variance_inflation = variance_inflation_of(rest.reshape(count, -1), trace)
    log_bf = tempered_log_bf(sums[:, None, :], information, variance_inflation)[:, 0]
    before, after = (
        each.reshape(count, width).sum(axis=1, dtype=np.float64) for each in (before, after)
    )
    survival = np.sqrt(after / np.maximum(before, 1e-300))
    parameters = found * scale.reshape(count, width)
    size = np.sqrt(np.mean((raw @ parameters[:, :, None])[:, :, 0] ** 2, axis=1))
    return [
        BayesFactor(
            candidate,
            float(log_bf[n]),
            float(variance_inflation[n]),
            float(survival[n]),
            parameters[n],
            float(size[n]),
            blocks[n].T,
            information[n],
            likelihood[n],
        )
        for n, candidate in enumerate(candidates)
    ]


def _by_block(values: Floats, whitened: Whitened) -> Floats:
    """Return the sums (..., B) over blocks of time of values (..., S N)."""
    return np.add.reduceat(values, whitened.starts, axis=-1).astype(np.float64)


def refined(whitened: Whitened, best: BayesFactor, *, tempered: bool = True) -> BayesFactor:
    """Return the score at the continuous shapes of largest log Bayes factor, one by one.

    Args:
        tempered: whether each shape is tempered, by what it leaves; else all are as by white noise.
    """

    def worth(score: BayesFactor) -> float:
        return score.log_bf if tempered else score.tempered(1.0)

    if not best.candidate.named:
        return best
    effect = best.candidate.effect
    grid = effect.candidates(whitened.x, best.candidate.joint)
    for shape in effect.shapes:
        value = best.candidate.shape.get(shape.name, 0.0)
        if shape.whole or not value > shape.zero:
            continue
        tried_first = [one[shape.name] for one in grid if shape.name in one]
        low, high = min(tried_first), max(tried_first)
        if not high > low > shape.zero:
            continue
        reach = ((high - shape.zero) / (low - shape.zero)) ** (
            1.0 / max(len(set(tried_first)) - 1, 1)
        )
        for _ in range(ROUNDS):
            mine = best.candidate
            steps = reach ** np.linspace(-0.75, 0.75, POINTS)
            away = mine.shape[shape.name] - shape.zero
            around = np.clip(shape.zero + away * steps, low, high).tolist()
            tried = [replace(mine, shape={**mine.shape, shape.name: value}) for value in around]
            best = max([best, *bayes_factors(whitened, tried)], key=worth)
            reach = reach**0.5
    return best


def best_shape(whitened: Whitened, scores: Sequence[BayesFactor]) -> BayesFactor:
    """Return an effect at its best shape, from its scores on a grid of shapes.

    A narrow place a little beside the true one leaves a torque of the same form, which counts
    against it, so that a wide place far off looks better. So two ways are tried: uphill from the
    best one; and uphill in what is explained, whatever is left, and from there. Where a motion
    knows one flank of a place, its middle and its width are known together alone: the last steps
    move all shapes at once.
    """
    most = max(scores, key=lambda one: one.tempered(1.0))
    starts = max(scores, key=lambda one: one.log_bf), refined(whitened, most, tempered=False)
    best = max((refined(whitened, one) for one in starts), key=lambda one: one.log_bf)
    return max(best, _polished(whitened, best), key=lambda one: one.log_bf)


def _polished(whitened: Whitened, best: BayesFactor) -> BayesFactor:
    """Return the score where all continuous shapes together explain most, near the best so far."""
    candidate = best.candidate
    shapes = [one for one in candidate.effect.shapes if not (one.whole or one.joint)]
    if len(shapes) < 2:
        return best
    grid = candidate.effect.candidates(whitened.x, candidate.joint)
    places = np.array([[shape.logarithm(one[shape.name]) for shape in shapes] for one in grid])
    low, high = places.min(axis=0), places.max(axis=0)
    begin = np.array([shape.logarithm(candidate.shape[shape.name]) for shape in shapes])
    steps = (high - low) / np.maximum([len(set(one)) - 1 for one in places.T.tolist()], 1)
    inwards = np.where(begin > 0.5 * (low + high), -NEAR, NEAR) * steps

    def at(place: Floats) -> BayesFactor:
        logs = zip(shapes, place.tolist(), strict=True)
        shape = {one.name: one.value(log) for one, log in logs}
        made = replace(candidate, shape={**candidate.shape, **shape})
        return bayes_factors(whitened, [made])[0]

    found = scipy.optimize.minimize(
        lambda place: -at(place).tempered(1.0),
        begin,
        method="Nelder-Mead",
        bounds=list(zip(low, high, strict=True)),
        options={
            "maxfev": LOOKS,
            "fatol": 0.1,
            "xatol": 1e-4,
            "initial_simplex": [begin, *(begin + np.diag(inwards))],
        },
    )
    return at(found.x)


def log_bayes_factor_of(score: BayesFactor, whitened: Whitened, without: float) -> float:
    """Return the log Bayes factor of a candidate, tempered as its score is.

    Args:
        score: of the candidate on `whitened`.
        whitened: with the hyperparameters that suit the candidate, but without it.
        without: the best log evidence that is reached without it.
    """
    joint, columns = score.candidate.joint, score.candidate.columns(whitened.x)
    scale = expected(columns, float(whitened.spread[joint]))
    # Scaled by the prior, so that parameters of any unit are comparable.
    scaled = (columns * scale)[:, scale > 0.0]
    more = Nuisance(joint, scaled, score.candidate.others)
    nuisance = (more, *whitened.problem.nuisance)
    system = whitened.explaining(whitened.basis, nuisance).system
    own = slice(whitened.basis.size, whitened.basis.size + scaled.shape[1])
    # The restricted evidence has a flat prior: multiply by the prior's density at the estimate.
    covariance = np.eye(scaled.shape[1]) + system.amplitude * system.covariance[own, own]
    found = system.coefficients[own]
    squares = found @ np.linalg.solve(covariance, found)
    spread = np.linalg.slogdet(2.0 * np.pi * covariance)[1]
    density = -0.5 * float(squares + spread)
    return (system.log_evidence + density - without) / score.variance_inflation
