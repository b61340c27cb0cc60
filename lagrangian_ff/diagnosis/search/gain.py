"""The gain in log evidence of adding a candidate, with a noise that may be correlated in time.

With w the whitened residual, Z the candidate's whitened columns with what is known projected out,
and a prior of a torque of 0.3 of the joint's spread on its parameters, the gain is

    ½ cᵀ (A + I)⁻¹ c − ½ log |A + I|,   A = ZᵀZ / f,   c = Zᵀw / f.

f ≥ 1 tempers the likelihood: it is how much more the sums over blocks of time scatter than white
noise would let them, after the candidate itself is taken away. What is left where the prior was
wrong thus counts as the few independent blocks it is, not as so many samples.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.ground import Ground
from lagrangian_ff.diagnosis.search.candidates import Candidate

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

PRIOR_SHARE = 0.3
"""Standard deviation of an effect's torque a priori, in parts of the joint's spread."""
COLUMNS_AT_ONCE = 256


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

    def gain_of(self, sums: Floats) -> Floats:
        """(R,) the gain for other sums (R, P) of scaled columns times residual."""
        return tempered_gain(sums, self.information, self.inflation)


def tempered_gain(sums: Floats, information: Floats, inflation: float) -> Floats:
    """(R,) ½ cᵀ (A + I)⁻¹ c − ½ log |A + I| for sums (R, P)."""
    matrix = np.eye(len(information)) + information / inflation
    c = sums / inflation
    half = np.linalg.solve(matrix, c.T).T
    return np.asarray(0.5 * np.sum(c * half, axis=1) - 0.5 * np.linalg.slogdet(matrix)[1])


def expected(columns: Floats, spread: float) -> Floats:
    """(P,) the prior's standard deviation of what columns (S, P) are multiplied by.

    That of a torque of 0.3 of the joint's spread, N·m; 0 where a column is zero.
    """
    rms = np.sqrt(np.mean(columns**2, axis=0))
    return np.asarray(PRIOR_SHARE * spread / np.where(rms > 0.0, rms, np.inf))


def scores(
    ground: Ground, candidates: Sequence[Candidate], *, coarse: bool = False
) -> Iterator[Score]:
    """Hold candidates against the residual of a ground; one triangular solve a column.

    Args:
        ground: of the motion.
        candidates: which; in any order.
        coarse: in single precision, for a first look at many.
    """
    x = ground.seen
    for joint in range(ground.joints):
        waiting: list[tuple[Candidate, Floats]] = []
        width = 0
        for candidate in (one for one in candidates if one.joint == joint):
            columns = candidate.columns(x)
            waiting.append((candidate, columns))
            width += columns.shape[1]
            if width >= COLUMNS_AT_ONCE:
                yield from _scored(ground, joint, waiting, coarse)
                waiting, width = [], 0
        if waiting:
            yield from _scored(ground, joint, waiting, coarse)


def _scored(
    ground: Ground,
    joint: int,
    waiting: Sequence[tuple[Candidate, Floats]],
    coarse: bool,
) -> Iterator[Score]:
    raw = np.hstack([columns for _, columns in waiting])
    scale = expected(raw, float(ground.spread[joint]))
    whitened = ground.whiten(raw * scale, joint, coarse=coarse)
    before = np.sum(whitened**2, axis=0)
    left = ground.project(whitened)
    after = np.sum(left**2, axis=0)
    w = ground.residual
    first = 0
    for candidate, columns in waiting:
        last = first + columns.shape[1]
        part = slice(first, last)
        first = last
        z, own = left[:, part], scale[part]
        # What the known columns explain but for rounding is not there.
        z = np.where(
            after[part] > (1e-7 if coarse else 1e-10) * np.maximum(before[part], 1e-300), z, 0.0
        )
        information = z.T @ z
        sums = z.T @ w
        found = np.linalg.solve(information + np.eye(len(sums)), sums)
        fitted = z @ found
        rest = np.add.reduceat(z * (w - fitted)[:, None], ground.starts, axis=0)
        trace = float(np.trace(information))
        inflation = max(1.0, float(np.sum(rest**2)) / trace) if trace > 0.0 else 1.0
        yield Score(
            candidate,
            float(tempered_gain(sums[None, :], information, inflation)[0]),
            inflation,
            float(np.sqrt(after[part].sum() / max(before[part].sum(), 1e-300))),
            found * own,
            float(np.sqrt(np.mean((columns @ (found * own)) ** 2))),
            np.add.reduceat(z * w[:, None], ground.starts, axis=0),
            information,
            np.add.reduceat(fitted * (w - 0.5 * fitted), ground.starts),
        )
