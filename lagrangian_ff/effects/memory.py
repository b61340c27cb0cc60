"""What an effect with a memory remembers: a recursion over the samples of a motion."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@njit(cache=True)
def stop(q: Floats, segment: Ints, start: Floats, width: float) -> Floats:
    """The stop operator q - play(q): how far an elastic contact that slides is deflected.

    The deflection follows the position until it reaches the width, then the contact slides
    (Krasnosel'skii and Pokrovskii 1989). It begins anew with every uninterrupted stretch.

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
