"""Marks that instruments leave: the step of an encoder, the limit of a torque."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_ROUNDING = 1e-12  # of the largest value: differences below are floating point
_MULTIPLE = 0.1  # of a step: how near to a multiple counts as one
_AGREEING = 0.98  # share of the differences that must be multiples
_PILE = 5  # times as many samples as on the neighbouring values make a clipped effort
_REST = 3  # samples in a row at the extreme


def resolution(position: Floats) -> float | None:
    """The step of which the values are multiples (same unit); None where there is none.

    The median of the differences between neighbouring distinct values, small ones taken first,
    refined by dividing all small differences by their numbers of steps.
    """
    values = np.unique(position[np.isfinite(position)])
    if values.size < 3:
        return None
    floor = _ROUNDING * max(np.abs(values).max(), 1.0)
    difference = np.diff(values)
    difference = np.sort(difference[difference > floor])
    if difference.size < 2:
        return None
    # A tenth of the differences being single steps is enough to see the step.
    step = float(difference[difference.size // 20])
    near = difference[difference < 20 * step]
    for _ in range(3):
        count = np.round(near / step)
        whole = count > 0
        if not whole.any():
            return None
        step = float(near[whole].sum() / count[whole].sum())
    off = np.abs(near / step - np.round(near / step))
    return step if np.mean(off < _MULTIPLE) >= _AGREEING else None


def clipped(effort: Floats) -> list[tuple[float, float]]:
    """Extreme values at which (M,) rests, each with its share of the samples.

    Clipped is what lies at its largest or smallest value several samples in a row and many
    times as often as near it; a smooth peak, even a coarsely quantised one, is not.
    """
    known = effort[np.isfinite(effort)]
    if known.size < 10 * _REST or np.ptp(known) == 0:
        return []
    found = []
    for sign in (1, -1):
        signed = sign * known
        top = signed.max()
        at_top = signed >= top - 1e-9 * abs(top)
        below = signed[~at_top]
        # Two further values, as far below as the nearest one: the slope of the distribution.
        nearest = top - below.max()
        beside = np.count_nonzero(below >= top - 2.5 * nearest) / 2
        if at_top.sum() > _PILE * max(beside, 1) and _longest_run(at_top) >= _REST:
            found.append((float(sign * top), float(at_top.mean())))
    return found


def _longest_run(flags: NDArray[np.bool_]) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return int((edges[1::2] - edges[::2]).max(initial=0))
