"""What effects with a memory remember: recursions over the samples of a motion.

Each begins anew with every uninterrupted stretch, as if what came before had settled.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@njit(cache=True)
def stop(q: Floats, segment: Ints, start: Floats, width: float) -> Floats:
    """The stop operator q - play(q): how far an elastic contact that slides is deflected.

    The deflection follows the position until it reaches the width, then the contact slides
    (Krasnosel'skii and Pokrovskii 1989).

    Args:
        q: (M,) rad.
        segment: (M,) samples recorded without interruption share a number.
        start: (M,) the deflection over the width; taken at the first sample of a stretch.
        width: rad, the deflection at which it slides.

    Returns:
        (M,) the deflection over the width, -1 to 1.
    """
    out = np.empty(q.size)
    for i in range(q.size):
        if i == 0 or segment[i] != segment[i - 1]:
            out[i] = min(1.0, max(-1.0, start[i]))
        else:
            out[i] = min(1.0, max(-1.0, out[i - 1] + (q[i] - q[i - 1]) / width))
    return out


@njit(cache=True)
def lag(values: Floats, time: Floats, segment: Ints, constant: float) -> Floats:
    """Values that follow with a lag of first order, each held until the next sample.

    Args:
        values: (M,).
        time: (M,) s; where it is not finite the lag has settled.
        segment: (M,) samples recorded without interruption share a number.
        constant: s, the time constant.

    Returns:
        (M,) in the unit of the values.
    """
    out = np.empty(values.size)
    for i in range(values.size):
        passed = time[i] - time[i - 1] if i > 0 else np.inf
        if i == 0 or segment[i] != segment[i - 1] or not np.isfinite(passed):
            out[i] = values[i]
        else:
            out[i] = values[i - 1] + (out[i - 1] - values[i - 1]) * np.exp(-passed / constant)
    return out
