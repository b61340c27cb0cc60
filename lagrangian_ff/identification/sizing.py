"""How much of a motion a model is made from, and whether it is solved exactly or on landmarks."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.settings import Settings

Ints = NDArray[np.int64]

EXACT_TORQUES = 9_000
"""Torques solved together beyond which an exact fit takes minutes and more than 2 GB."""
LONG = 12_000
"""Training samples, two minutes at 100 Hz, of which the few of an exact fit leave out too much."""
LANDMARKS = 300
"""Enough for six joints: with twice as many, the error on simulated recordings is the same."""


@dataclass(frozen=True)
class Sizes:
    """Which samples do what; each holds positions in the motion.

    Attributes:
        few: (F,) hyperparameters are chosen on.
        centres: (C,) the kernel is built on.
        seen: (M,) determine the coefficients; the centres themselves where the fit is exact.
    """

    few: Ints
    centres: Ints
    seen: Ints


def sizes(available: Ints, settings: Settings, width: int) -> Sizes:
    """What a motion is used for.

    Args:
        available: (K,) positions of all samples that may be learned from.
        settings: see `Settings.samples` and `Settings.landmarks`.
        width: how many joints are solved together.
    """
    most = EXACT_TORQUES // width
    landmarks = settings.landmarks
    if landmarks is None:
        beyond = min(settings.samples, len(available)) > most
        landmarks = LANDMARKS if beyond or len(available) > LONG else 0
    if landmarks == 0 or landmarks >= len(available):
        samples = settings.samples if landmarks == 0 else len(available)
        few = available[evenly(len(available), samples)]
        return Sizes(few, few, few)
    few = available[evenly(len(available), min(settings.samples, most))]
    return Sizes(few, available[evenly(len(available), landmarks)], available)
