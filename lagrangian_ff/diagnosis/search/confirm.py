"""Does what was found hold on motion that the search has not seen, with nothing fitted again?"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.ground import Ground, lay
from lagrangian_ff.diagnosis.ground.ground import Extra
from lagrangian_ff.diagnosis.ground.tuning import BLOCK_SECONDS, ROWS
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.diagnosis.search.change import Change
from lagrangian_ff.diagnosis.search.gain import Score
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

PIECE = 0.5  # s
GROUP_NATS = (2.0, 4.0)
"""Pieces of motion are put together until the effect should gain so much in a group: less is noise,
and more makes the groups too few."""
FEWEST_GROUPS, GROUPS, MOST_GROUPS = 5, 6, 8
"""More groups than the last would be as short as what the model leaves over is correlated."""
ROUNDING = 1e-9
SHARE = 0.75
LEVEL = 0.05
RATIO = (0.5, 1.6)
"""How much larger or smaller than found the effect may be on the other motion."""


@dataclass(frozen=True)
class Trial:
    """A frozen effect on motion that was not used to find it.

    Attributes:
        expected: (G,) nats it should gain in each group of blocks if it is there as found.
        gained: (G,) nats it does gain.
        ratio: its size on this motion relative to that found, 1 if it is the same.
        p_value: how often the gains lie so far above zero by chance (Wilcoxon's signed ranks).
        reason: why it does not hold; empty if it does.
    """

    expected: Floats
    gained: Floats
    ratio: float
    p_value: float
    reason: str

    @property
    def holds(self) -> bool:
        """Whether it helps on most of the motion, by chance almost never, at the size found."""
        return not self.reason

    @property
    def share(self) -> float:
        """The share of groups in which it helps."""
        return float(np.mean(self.gained > 0.0)) if len(self.gained) else 0.0


@dataclass(frozen=True)
class Unseen:
    """Another motion, whitened as the first was, with all that was found taken away.

    Attributes:
        ground: its ground; the residual has everything found taken away, frozen.
        torques: for each found effect, (S,) N·m of it at the samples used.
    """

    ground: Ground
    torques: tuple[Floats, ...]

    @classmethod
    def lay(
        cls,
        motion: Motion,
        found: Ground,
        model: Basis,
        taken: Sequence[tuple[Candidate, Floats]],
        change: Change | None = None,
    ) -> "Unseen":
        """Whiten a motion with a prior and effects that come from another.

        Args:
            motion: not used in the search.
            found: the last ground of the search.
            model: the basis that the model had, its shapes tuned; its parameters stay free.
            taken: what was found, with frozen parameters; with none, (0,), it stays free, as a
                dependence without a name always does, and the load is predicted without it.
            change: where this motion takes up a load, if the first one did.
        """
        prior = found.prior
        if prior.change is not None:
            prior = replace(prior, change=change.prior if change else None)
        index = evenly(len(motion), ROWS // len(motion.joints))
        block = motion.blocks(BLOCK_SECONDS)[index]
        whole = Basis((*model.terms, *(c.term() for c, b in taken if c.named and len(b))))
        ground = lay(motion, index, block, found.inputs_of(motion), prior, whole)
        inputs = ground.inputs_of(motion)
        x = replace(ground, inputs=inputs).unseen_inputs()
        tau = motion.tau.copy()
        torques, extra = [], []
        for candidate, parameters in taken:
            if not candidate.named or not len(parameters):
                extra.append(Extra(candidate.joint, candidate.columns(x)))
                torques.append(np.zeros(len(index)))
                continue
            torque = candidate.columns(x.whole or x) @ parameters
            tau[:, candidate.joint] -= torque
            torques.append(x.mean(torque))
        system = ground.system
        ground = lay(replace(motion, tau=tau), index, block, inputs, prior, model, extra, x, system)
        return cls(ground, tuple(torques))

    def trial(self, parts: Sequence[tuple[int, int]]) -> Trial:
        """Effects put back and taken away again, all at once.

        Args:
            parts: the number of each, and its joint.
        """
        ground = self.ground
        z = np.zeros_like(ground.residual)
        for number, joint in parts:
            z += ground.project(ground.whiten(self.torques[number][:, None], joint))[:, 0]
        return _trial(ground, z)

    def rival(self, score: Score, instead_of: int) -> Floats:
        """(B,) nats gained by a rival, frozen, where an effect that was found is put back."""
        ground, candidate = self.ground, score.candidate
        joint = candidate.joint
        back = ground.project(ground.whiten(self.torques[instead_of][:, None], joint))[:, 0]
        torque = candidate.columns(ground.seen) @ score.coefficients
        z = ground.project(ground.whiten(torque[:, None], joint))[:, 0]
        w = ground.residual + back
        return np.asarray(np.add.reduceat(z * (w - 0.5 * z), ground.starts))


def _trial(ground: Ground, z: Floats) -> Trial:
    """What was taken away, whitened, put back and taken away again."""
    w = ground.residual + z
    gained = _by_piece(ground, z * (w - 0.5 * z))
    expected = _by_piece(ground, 0.5 * z * z)
    power = float(z @ z)
    ratio = float(z @ w) / power if power > 0.0 else 0.0
    gains, hoped = grouped(gained, expected)
    if len(gains) < FEWEST_GROUPS:
        reason = "the unseen motion is too short, or hardly shows the effect, to confirm it"
        return Trial(hoped, gains, ratio, 1.0, reason)
    p_value = signed_ranks(gains)
    share = float(np.mean(gains > 0.0))
    reason = ""
    if share < SHARE or p_value > LEVEL:
        reason = f"it helps in {share:.0%} of the unseen motion (p = {p_value:.2g}), too little"
    elif not RATIO[0] < ratio < RATIO[1]:
        reason = f"on the unseen motion it is {ratio:.2g} times as large: not the same effect"
    return Trial(hoped, gains, ratio, p_value, reason)


def signed_ranks(gains: Floats) -> float:
    """Return how often random signs put as much rank above zero (Wilcoxon 1945), exactly.

    Args:
        gains: (G,) of a few groups: all 2ᴳ signs are tried.
    """
    rank = 1.0 + np.argsort(np.argsort(np.abs(gains)))
    above = ((np.arange(2 ** len(gains))[:, None] >> np.arange(len(gains))) & 1) @ rank
    return float(np.mean(above >= rank[gains > 0.0].sum()))


def _by_piece(ground: Ground, values: Floats) -> Floats:
    piece = np.floor(ground.seen.time / PIECE) if np.isfinite(ground.seen.time).all() else 0.0
    changes = np.diff(ground.block) != 0
    changes |= np.diff(np.broadcast_to(piece, len(ground.block))) != 0.0
    starts = np.concatenate([[0], np.flatnonzero(changes) + 1]) * ground.joints
    return np.asarray(np.add.reduceat(values, starts))


def grouped(gained: Floats, expected: Floats) -> tuple[Floats, Floats]:
    """Neighbouring pieces put together until enough is expected of each group.

    Pieces come whole: what one group got beyond its share, the next need not wait for.
    """
    total = float(expected.sum())
    least = max(float(np.clip(total / GROUPS, *GROUP_NATS)), total / MOST_GROUPS)
    groups: list[float] = []
    hoped: list[float] = []
    fewest = max(GROUP_NATS[0], 0.5 * least)
    sums, reached = np.zeros(2), 0.0
    for one, hope in zip(gained, expected, strict=True):
        sums += (one, hope)
        reached += hope
        # The last group reaches the total but for rounding.
        if sums[1] >= fewest and reached >= (1.0 - ROUNDING) * (len(groups) + 1) * least:
            groups.append(sums[0])
            hoped.append(sums[1])
            sums = np.zeros(2)
    if groups:
        groups[-1] += sums[0]
        hoped[-1] += sums[1]
    return np.array(groups), np.array(hoped)
