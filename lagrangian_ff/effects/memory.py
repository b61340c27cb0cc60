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


SUBSTEPS = 8


@njit(cache=True)
def loose(load: Floats, part: Floats, step: float, play: float, blow: float) -> Floats:
    """What a gear with play carries of a part of its load.

    Teeth that touch carry all of it. Where it turns its sign they part: nothing is carried, and the
    motor runs ahead by `load / play` in units of the gap, until the teeth touch on one side or the
    other. What it has gained on the way is then carried back within `blow`: over a crossing, no
    momentum is lost.

    Args:
        load: (M,) N·m, of an uninterrupted stretch; it decides when the teeth touch.
        part: (M,) of the load, all of it or what goes with it; held and let go together.
        step: s between samples.
        play: kg·m²·rad, inertia of the link times the play.
        blow: s, time constant of the blow.

    Returns:
        (M,) as `part`.
    """
    out = np.empty(load.size)
    h = step / SUBSTEPS
    passed = 1.0 - np.exp(-h / blow)
    ahead, speed = (0.5 if load[0] > 0.0 else -0.5), 0.0
    gained, momentum = 0.0, 0.0
    for i in range(load.size):
        last = i + 1 == load.size
        change = 0.0 if last else load[i + 1] - load[i]
        part_change = 0.0 if last else part[i + 1] - part[i]
        carried = 0.0
        for k in range(SUBSTEPS):
            now = load[i] + change * k / SUBSTEPS
            if (ahead >= 0.5 and now >= 0.0) or (ahead <= -0.5 and now <= 0.0):
                carried += part[i] + part_change * k / SUBSTEPS
            else:
                speed += h * now / play
                ahead += h * speed
                gained += h * (part[i] + part_change * k / SUBSTEPS)
                if abs(ahead) >= 0.5:
                    momentum += gained
                    ahead, speed, gained = (0.5 if ahead > 0.0 else -0.5), 0.0, 0.0
            carried += momentum * passed / h
            momentum -= momentum * passed
        out[i] = carried / SUBSTEPS
    return out
