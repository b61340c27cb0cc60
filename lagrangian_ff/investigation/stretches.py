"""The parts of motions that are learned from, and those that confirm."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from lagrangian_ff.recording import Motion

LEARNED = 0.6
"""Share of each stretch of a motion that is learned from and searched; the rest confirms and
judges."""
STRETCH = 8.0
"""s of such stretches, about. A designed motion is slow in one place and fast in another: what is
learned from must have seen each, or what confirms only shows how badly a model extrapolates."""


def learned_and_unseen(
    motions: Sequence[Motion], share: float = LEARNED, stretch: float = STRETCH
) -> tuple[list[Motion], list[Motion]]:
    """Return the first share of each stretch of each motion, and the rest of each.

    Args:
        stretch: s, about; infinite for whole motions.
    """
    learned, unseen = [], []
    for motion in motions:
        count = max(1, round(motion.elapsed[-1] / stretch))
        ends = np.linspace(0, len(motion), count + 1).round().astype(int)
        for begin, end in pairwise(ends.tolist()):
            cut = begin + round(share * (end - begin))
            learned.append(motion.take(slice(begin, cut)))
            unseen.append(motion.take(slice(cut, end)))
    return learned, unseen


def closely(motion: Motion) -> Motion:
    """Return a motion that is looked at more closely than others."""
    return replace(motion, closely=np.ones(len(motion), dtype=bool))
