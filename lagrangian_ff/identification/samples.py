"""The samples that a model is learned from, and their choice among many."""

from dataclasses import dataclass
from math import ceil

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.settings import Settings
from lagrangian_ff.kernels import States
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.sampling import usual_step

RATE = 100.0
"""Hz that a model keeps; the paper's low-pass leaves nothing above a quarter of it."""
MOST_KEPT = 60_000
"""Samples kept at most: ten minutes at full rate."""
EXACT_TORQUES = 9_000
"""Torques solved together beyond which an exact fit takes minutes and more than 2 GB."""
LONG = 12_000
"""Training samples, two minutes at 100 Hz, beyond which the subset of an exact fit is too small."""
INDUCING_POINTS = 300
"""Enough for six joints: with twice as many, the error on simulated recordings is the same."""
CHEAP = (500 * 6) ** 3 / 3
"""Products, those of an exact fit to 500 samples of six joints: where inducing points need no more,
nothing is gained by learning from a subset."""


@dataclass(frozen=True)
class Samples:
    """States and torques that a model is learned from.

    Attributes:
        x: (S, N) as effects see them.  tau: (S, N) N·m.
        fold: (S,) the fold that each sample is left out with; None has no folds.
        weight: (S, N) IRLS weight of each torque, whose noise is 1 / weight times as large; None
            is 1 for all.
    """

    x: Inputs
    tau: Floats
    fold: Ints | None = None
    weight: Floats | None = None

    def __len__(self) -> int:
        return len(self.x)

    @property
    def states(self) -> States:
        """Return the states (S, N)."""
        return States(self.x.q, self.x.qd, self.x.qdd)

    @property
    def weights(self) -> Floats:
        """Return the IRLS weights (S, N), as numbers."""
        return np.ones_like(self.tau) if self.weight is None else self.weight

    def take(self, index: Ints) -> "Samples":
        """Return some of them."""
        fold = None if self.fold is None else self.fold[index]
        weight = None if self.weight is None else self.weight[index]
        return Samples(self.x.take(index), self.tau[index], fold, weight)

    def thinned(self, count: int) -> "Samples":
        """Return at most this many, evenly spread."""
        return self.take(evenly(len(self), count))

    def groups(self) -> list[Ints]:
        """Return the samples of each fold."""
        return [] if self.fold is None else groups(self.fold)


def groups(part: Ints) -> list[Ints]:
    """Return the samples of each part, given the one that each sample lies in (S,)."""
    return [np.flatnonzero(part == number) for number in np.unique(part)]


def evenly(available: int, wanted: int) -> Ints:
    """Return positions of at most `wanted` samples, evenly spread over those available."""
    if wanted >= available:
        return np.arange(available)
    return np.round(np.linspace(0, available - 1, wanted)).astype(np.int64)


def moving(motion: Motion, wanted: int) -> Ints:
    """Return positions of at most `wanted` samples, evenly spread over those where a joint moves.

    They are spread over all samples of a motion that never moves.
    """
    found = np.flatnonzero(~motion.rest.all(axis=1))
    found = found if len(found) else np.arange(len(motion))
    return np.asarray(found[evenly(len(found), wanted)])


@dataclass(frozen=True)
class Sizes:
    """The uses of samples; each array holds positions in the motion.

    Attributes:
        subset: (F,) for choosing hyperparameters.  centres: (C,) for building the kernel.
        seen: (M,) for the coefficients; the centres themselves if the fit is exact.
    """

    subset: Ints
    centres: Ints
    seen: Ints


def sizes(available: Ints, settings: Settings, width: int, structured: bool = False) -> Sizes:
    """Return the uses of the samples of a motion.

    Args:
        available: (K,) positions of all samples that may be learned from.
        settings: see `Settings.samples` and `Settings.landmarks`.
        width: number of joints that are solved together.
        structured: whether the kernel knows mechanics; of few joints it then has few features,
            which the inducing points span.
    """
    most = EXACT_TORQUES // width
    landmarks = settings.landmarks
    if landmarks is None:
        beyond = min(settings.samples, len(available)) > most
        work = len(available) * width * (INDUCING_POINTS * width) ** 2
        cheap = structured and settings.samples > INDUCING_POINTS and work <= CHEAP
        landmarks = INDUCING_POINTS if beyond or cheap or len(available) > LONG else 0
    if landmarks == 0 or landmarks >= len(available):
        samples = settings.samples if landmarks == 0 else len(available)
        subset = available[evenly(len(available), samples)]
        return Sizes(subset, subset, subset)
    subset = available[evenly(len(available), min(settings.samples, most))]
    return Sizes(subset, available[evenly(len(available), landmarks)], available)


def decimated(motion: Motion) -> Motion:
    """Return every k-th sample of a motion, so that 100 Hz or a little more are left.

    A model keeps these: enough to refit it, and to look at it again.
    """
    period = usual_step(motion.time, motion.segment) or 1.0 / RATE
    every = max(1, int(1.0 / (RATE * period) + 1e-6), ceil(len(motion) / MOST_KEPT))
    return motion if every == 1 else motion.take(slice(None, None, every))
