"""Searching a few numbers for the least error, on few samples first and on all last."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

Floats = NDArray[np.float64]

STAGES = ((0.25, 0.55), (0.5, 0.3), (1.0, 0.15))
"""Share of the samples, and of the evaluations, of each stage."""
EVALUATIONS = 20
"""Of each number, over all stages."""
CLOSER = 0.4
"""How much shorter the first steps of a stage are than those of the stage before."""


@dataclass(frozen=True)
class Axis:
    """A positive number that is searched on its logarithm.

    Attributes:
        name: whose.  start, low, high: where the search begins, and how far it may go.
        step: of the logarithm, the first one.
    """

    name: str
    start: float
    low: float
    high: float
    step: float


def least(cost: Callable[[Floats, float], float], axes: Sequence[Axis]) -> Floats:
    """The numbers with the least cost that a simplex search finds (Nelder and Mead).

    Args:
        cost: of some numbers (A,), on a share of the samples.
        axes: the A numbers; none are searched where there are none.
    """
    point = np.log([axis.start for axis in axes])
    if not axes:
        return point
    bounds = np.log([(axis.low, axis.high) for axis in axes])
    step = np.array([axis.step for axis in axes])
    for samples, share in STAGES:
        corners = np.clip([point, *(point + np.diag(step))], *bounds.T)

        def of(values: Floats, samples: float = samples) -> float:
            return cost(np.exp(values), samples)

        found = minimize(
            of,
            point,
            method="Nelder-Mead",
            bounds=bounds,
            options={
                "initial_simplex": corners,
                "maxfev": max(round(share * EVALUATIONS * len(axes)), len(axes) + 2),
                "xatol": 0.03,
                "fatol": 1e-3,
            },
        )
        point, step = np.asarray(found.x), CLOSER * step
    return np.exp(point)
