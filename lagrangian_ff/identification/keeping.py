"""The part of a motion that a model keeps: enough to refit it, and to look at it again."""

from math import ceil

import numpy as np

from lagrangian_ff.recording.motion import Motion

RATE = 100.0  # Hz; the paper's low-pass leaves nothing above a quarter of it
MOST = 60_000
"""Samples kept at most: ten minutes at full rate."""


def kept(motion: Motion) -> Motion:
    """Every k-th sample of a motion, so that 100 Hz or a little more are left."""
    steps = np.diff(motion.time)
    steps = steps[np.diff(motion.segment) == 0]
    period = float(np.median(steps)) if len(steps) else 1.0 / RATE
    every = max(1, int(1.0 / (RATE * period) + 1e-6), ceil(len(motion) / MOST))
    return motion if every == 1 else motion.take(slice(None, None, every))
