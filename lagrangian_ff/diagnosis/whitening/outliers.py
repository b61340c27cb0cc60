"""Outliers of a motion: torques far from all that is explained, and how much they count.

A gear that sticks for a moment leaves ten times the noise, where its form of friction is not quite
the true one. A few such moments make up most of the noise of a joint, and would hide from the
search what all other samples show. They count less once nothing stands out any more, so that what
shows in outliers alone has been looked for before. The weights are those of Huber (1964), squared,
see `identification.solving.robust`.
"""

from dataclasses import replace

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.whitening.hyperparameters import refit
from lagrangian_ff.diagnosis.whitening.whitened import Whitened, whiten
from lagrangian_ff.identification.solving.robust import DEVIATION, heavy_tailed, weights_of

FAR = 4.0
"""Standard deviations from which on a torque is an outlier."""
MUCH = 0.1
"""Share of a joint's squared residual that outliers make up where they hide the rest."""
NEAR = 2.0
"""Standard deviations from which on a torque of such a joint counts less."""
ROUNDS = 2


def outweighed(whitened: Whitened) -> Whitened | None:
    """Return the motion with outliers counting less, hyperparameters refitted; None without any."""
    found = None
    for _ in range(ROUNDS):
        weight = weights(whitened)
        if weight is None:
            return found
        problem = whitened.problem.weighted(weight)
        light = replace(whitened, problem=problem)
        found = whitened = light.assuming(refit(light, light.basis, problem.nuisance))
    return found


def in_full(whitened: Whitened) -> Whitened:
    """Return the motion with all torques counting in full, hyperparameters refitted."""
    if whitened.problem.samples.weight is None:
        return whitened
    plain = replace(whitened, problem=whitened.problem.weighted(None))
    return plain.assuming(refit(plain, plain.basis, plain.problem.nuisance))


def counting_less(whitened: Whitened) -> Whitened:
    """Return the motion with outliers counting less, with the same hyperparameters."""
    weight = weights(whitened)
    if weight is None:
        return whitened
    parts = whitened.motion, whitened.index, whitened.seconds, whitened.inputs
    problem, lagging = whitened.problem.weighted(weight), whitened.lagging
    return whiten(*parts, problem, whitened.x, weight=weight, lagging=lagging)


def weights(whitened: Whitened) -> Floats | None:
    """Return (S, N) by how much the noise of each torque is divided; None if no joint has outliers.

    Torques count as they are on joints without outliers.
    """
    x = whitened.x
    left = whitened.system.residual.reshape(len(x), -1)
    left = np.ma.masked_array(left, x.rest)
    deviation = DEVIATION * np.ma.median(np.abs(left), axis=0).filled(0.0)
    squares = left.filled(0.0) ** 2
    far = np.sum(squares * (squares > (FAR * deviation) ** 2), axis=0)
    heavy = far > MUCH * squares.sum(axis=0)
    if not heavy.any():
        return None
    near = np.maximum(NEAR * deviation, np.finfo(float).tiny)
    return np.where(heavy, heavy_tailed(weights_of(left.filled(0.0), near)), 1.0)
