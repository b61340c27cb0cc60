"""Marks that instruments leave: the step of an encoder, the limit of a torque."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_ROUNDING = 1e-12  # of the largest value: differences below are floating point
_MULTIPLE = 0.1  # of a step: how near to a multiple counts as one
_AGREEING = 0.98  # share of the differences that must be multiples
_FEWEST = 10  # differences to judge by
_PILE = 5  # times as many samples as on the neighbouring values make a clipped effort
_REST = 3  # samples in a row at the extreme


def resolution(position: Floats) -> float | None:
    """The step of which the values are multiples (same unit); None where there is none.

    The smallest difference between distinct values, or a half or third of it, of which all
    small differences must be multiples; refined by dividing these by their numbers of steps.
    """
    values = np.unique(position[np.isfinite(position)])
    if values.size < 3:
        return None
    floor = _ROUNDING * max(np.abs(values).max(), 1.0)
    difference = np.diff(values)
    difference = np.sort(difference[difference > floor])
    for parts in (1, 2, 3):
        if difference.size and (step := _common_step(difference, difference[0] / parts)):
            return step
    return None


def _common_step(difference: Floats, step: float) -> float | None:
    """The step near this one of which the small differences (sorted) are multiples."""
    for reach in (4, 12, 40, 120):
        near = difference[difference < (reach + 0.5) * step]
        count = np.round(near / step)
        if near.size == 0 or count.min() < 1:
            return None
        step = float(near.sum() / count.sum())
    off = np.abs(near / step - np.round(near / step))
    agree = near.size >= _FEWEST and np.mean(off < _MULTIPLE) >= _AGREEING
    return step if agree else None


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
