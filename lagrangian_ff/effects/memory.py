"""Effects with a memory: recursions over the samples of a motion."""

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.loops import loop


def stop(q: Floats, segment: Ints, start: Floats, width: float) -> Floats:
    """Return the stop operator q - play(q): the deflection of an elastic contact that slides.

    The deflection follows the position until it reaches the width, then the contact slides
    (Krasnosel'skii and Pokrovskii 1989). It starts again in every uninterrupted stretch.

    Args:
        q: (M,) rad.
        segment: (M,) samples recorded without interruption share a number.
        start: (M,) the deflection over the width; taken at the first sample of a stretch.
        width: rad, the deflection at which it slides.

    Returns:
        (M,) the deflection over the width, -1 to 1.
    """
    out = np.empty(q.size)
    q, start = (np.ascontiguousarray(one, dtype=np.float64) for one in (q, start))
    loop("memory_stop")(q.size, q, np.ascontiguousarray(segment, dtype=np.int64), start, width, out)
    return out


def loose(load: Floats, part: Floats, step: float, play: float, blow: float) -> Floats:
    """Return what a gear with play carries of a part of its load.

    Teeth that touch carry all of it. Where it turns its sign they part: nothing is carried, and the
    motor runs ahead by `load / play` in units of the gap, until the teeth touch on one side or the
    other. The momentum gained on the way then comes back within `blow`: a crossing loses none.

    Args:
        load: (M,) N·m, of an uninterrupted stretch; it decides when the teeth touch.
        part: (M,) of the load, all of it or a part; held and let go together.
        step: s between samples.
        play: kg·m²·rad, inertia of the link times the play.
        blow: s, time constant of the blow.

    Returns:
        (M,) as `part`.
    """
    out = np.empty(load.size)
    load, part = (np.ascontiguousarray(one, dtype=np.float64) for one in (load, part))
    loop("memory_loose")(load.size, load, part, step, play, blow, out)
    return out


def swinging(values: Floats, step: float, w: float, damping: float) -> Floats:
    """Return values after the filter (2 z w s + w²) / (s² + 2 z w s + w²), at rest before them.

    Args:
        values: (M,) of an uninterrupted stretch.
        step: s between samples.
        w: rad/s, the resonance.  damping: z, in parts of critical.
    """
    loss = 2.0 * damping * w
    k = 2.0 / step  # s = k (z - 1) / (z + 1), the bilinear transform
    above = np.array([loss * k + w * w, 2.0 * w * w, w * w - loss * k])
    below = above + k * k * np.array([1.0, -2.0, 1.0])
    coefficients = np.concatenate([above, below[1:]]) / below[0]
    out = np.empty(values.size)
    given = np.ascontiguousarray(values - values[0])
    loop("memory_filter")(values.size, given, coefficients, out)
    return out + values[0]
