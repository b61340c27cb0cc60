"""The gain in log evidence of adding a candidate, with a noise that may be correlated in time.

With w the whitened residual, Z the candidate's whitened columns with what is known projected out,
and a prior of a torque of 0.3 of the joint's spread on its parameters, the gain is

    ½ cᵀ (A + I)⁻¹ c − ½ log |A + I|,   A = ZᵀZ / f,   c = Zᵀw / f.

f ≥ 1 tempers the likelihood: it is how much more the sums over blocks of time scatter than white
noise would let them, after the candidate itself is taken away. What is left where the prior was
wrong thus counts as the few independent blocks it is, not as so many samples.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.ground import Ground
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.kernels import threads

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

PRIOR_SHARE = 0.3
"""Standard deviation of an effect's torque a priori, in parts of the joint's spread."""
COLUMNS_AT_ONCE = 256
MANY = 64
"""Candidates from which on a second thread is worth its start."""


@dataclass(frozen=True)
class Score:
    """A candidate held against the residual.

    Attributes:
        candidate: which.
        gain: nats of log evidence, tempered.
        inflation: f.
        survival: the share of its whitened columns that what is known leaves over, 0 to 1.
        coefficients: (P,) its parameters, in their units.
        size: N·m, root mean square of its torque on the samples used.
        blocks: (B, P) sums over blocks of scaled columns times residual.
        information: (P, P) A without f.
        likelihood: (B,) nats that each block gains with these parameters, not tempered.
    """

    candidate: Candidate
    gain: float
    inflation: float
    survival: float
    coefficients: Floats
    size: float
    blocks: Floats
    information: Floats
    likelihood: Floats

    @property
    def once(self) -> bool:
        """Whether it is an event: something that happens once, in a few blocks."""
        return self.candidate.named and self.candidate.effect.kind == "event"


def tempered_gain(sums: Floats, information: Floats, inflation: Floats | float) -> Floats:
    """(..., R) ½ cᵀ (A + I)⁻¹ c − ½ log |A + I|.

    Args:
        sums: (..., R, P).  information: (..., P, P) and inflation: (...), of as many candidates.
    """
    f = np.asarray(inflation)[..., None, None]
    matrix = np.eye(information.shape[-1]) + information / f
    c = sums / f
    squares = np.sum(c @ np.linalg.inv(matrix) * c, axis=-1)
    return np.asarray(0.5 * squares - 0.5 * np.linalg.slogdet(matrix)[1][..., None])


def expected(columns: Floats, spread: float) -> Floats:
    """(P,) the prior's standard deviation of what columns (S, P) are multiplied by.

    That of a torque of 0.3 of the joint's spread, N·m; 0 where a column is zero.
    """
    rms = np.sqrt(np.mean(columns**2, axis=0))
    return np.asarray(PRIOR_SHARE * spread / np.where(rms > 0.0, rms, np.inf))


def scores(ground: Ground, candidates: Sequence[Candidate], *, coarse: bool = False) -> list[Score]:
    """Hold candidates against the residual of a ground.

    Args:
        ground: of the motion.
        candidates: which; in any order.
        coarse: in single precision, for a first look at many.

    Returns:
        Joint by joint, those of a joint in the order given.
    """
    parts = [[one for one in candidates if one.joint == joint] for joint in range(ground.joints)]
    parts = [mine for mine in parts if mine]
    if len(candidates) < MANY:
        return [score for mine in parts for score in _of_joint(ground, mine, coarse)]
    if len(parts) == 1:
        ground.response(parts[0][0].joint)  # once, for both threads
        half = len(parts[0]) // 2
        parts = [parts[0][:half], parts[0][half:]]
    found = threads.side_by_side(lambda mine: _of_joint(ground, mine, coarse), parts)
    return [score for some in found for score in some]


def _of_joint(ground: Ground, candidates: Sequence[Candidate], coarse: bool) -> list[Score]:
    """Scores of candidates on one joint, in their order."""
    columns = [one.columns(ground.seen) for one in candidates]
    widths = np.array([one.shape[1] for one in columns])
    held: dict[int, Score] = {}
    for width in np.unique(widths).tolist():
        places = np.flatnonzero(widths == width)
        for first in range(0, len(places), max(1, COLUMNS_AT_ONCE // max(1, width))):
            some = places[first : first + max(1, COLUMNS_AT_ONCE // max(1, width))].tolist()
            raw = np.stack([columns[n] for n in some])
            made = _scored(ground, [candidates[n] for n in some], raw, coarse)
            held.update(zip(some, made, strict=True))
    return [held[n] for n in range(len(candidates))]


def _scored(
    ground: Ground, candidates: Sequence[Candidate], raw: Floats, coarse: bool
) -> list[Score]:
    """Scores of candidates on one joint with as many columns each, raw (C, S, P)."""
    joint = candidates[0].joint
    count, samples, width = raw.shape
    flat = raw.transpose(1, 0, 2).reshape(samples, -1)
    scale = expected(flat, float(ground.spread[joint]))
    white = ground.whiten(flat * scale, joint, coarse=coarse).T
    before = np.einsum("kn,kn->k", white, white)
    span = ground.span.astype(white.dtype)
    left = white - (white @ span) @ span.T
    after = np.einsum("kn,kn->k", left, left)
    # What the known columns explain but for rounding is not there.
    left[after <= (1e-7 if coarse else 1e-10) * np.maximum(before, 1e-300)] = 0.0
    z, w = left.reshape(count, width, -1), ground.residual.astype(white.dtype)
    information = (z @ z.swapaxes(1, 2)).astype(np.float64)
    blocks = _by_block(z * w, ground)
    sums = blocks.sum(axis=2)
    found = np.linalg.solve(information + np.eye(width), sums[:, :, None])[:, :, 0]
    fitted = (found.astype(z.dtype)[:, None, :] @ z)[:, 0]
    likelihood = _by_block(fitted * (w - 0.5 * fitted), ground)
    z *= fitted[:, None]
    rest = blocks - _by_block(z, ground)
    trace = np.trace(information, axis1=1, axis2=2)
    scatter = np.sum(rest**2, axis=(1, 2)) / np.where(trace > 0.0, trace, np.inf)
    inflation = np.maximum(1.0, scatter)
    gain = tempered_gain(sums[:, None, :], information, inflation)[:, 0]
    before, after = (
        each.reshape(count, width).sum(axis=1, dtype=np.float64) for each in (before, after)
    )
    survival = np.sqrt(after / np.maximum(before, 1e-300))
    parameters = found * scale.reshape(count, width)
    size = np.sqrt(np.mean((raw @ parameters[:, :, None])[:, :, 0] ** 2, axis=1))
    return [
        Score(
            candidate,
            float(gain[n]),
            float(inflation[n]),
            float(survival[n]),
            parameters[n],
            float(size[n]),
            blocks[n].T,
            information[n],
            likelihood[n],
        )
        for n, candidate in enumerate(candidates)
    ]


def _by_block(values: Floats, ground: Ground) -> Floats:
    """(..., B) sums over blocks of time of values (..., S N)."""
    return np.add.reduceat(values, ground.starts, axis=-1).astype(np.float64)
