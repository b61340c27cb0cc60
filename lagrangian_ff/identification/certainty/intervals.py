"""Intervals of the effects' parameters that hold although residuals are correlated in time."""

import numpy as np
import scipy
from numpy.typing import NDArray

from lagrangian_ff.identification.samples import groups
from lagrangian_ff.identification.solving.fit import Fit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LEVEL = 0.9
"""The share of such intervals that should hold the true value."""


def reach(fitted: Fit, block: Ints) -> Floats:
    """How far 90 % intervals of the effects' parameters reach to both sides.

    The wider of two is taken: the model's own standard deviation, which believes the noise to be
    independent, and the jackknife over blocks of time (Künsch 1989), which does not. Both follow
    from the factor of the fit.

    Args:
        fitted: the model.
        block: (M,) the block of time each training sample lies in.

    Returns:
        (B,) in the parameters' physical units.
    """
    own = fitted.deviations
    blocks = groups(block)
    if len(blocks) < 3 or not len(own):
        return np.asarray(own * scipy.special.stdtrit(max(1, len(blocks) - 1), 0.5 + LEVEL / 2.0))
    changed = fitted.changed(blocks)
    count = len(blocks)
    spread = changed - changed.mean(axis=0)
    jackknife = np.sqrt((count - 1) / count * np.sum(spread**2, axis=0))
    factor = scipy.special.stdtrit(count - 1, 0.5 + LEVEL / 2.0)
    return np.asarray(np.maximum(own, jackknife) * factor)
