"""A pose that loads a joint, of those the arm has been in."""

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.excite.limits import Limits
from lagrangian_ff.identification import Model

Floats = NDArray[np.float64]

_LOOKED_AT = 400
_WAY_COUNTS = 0.3  # a pose at the end of every range must carry this share more of the torque


def seen_pose(model: Model, joint: str | None, limits: Limits) -> Floats:
    """(N,) rad, a pose of the model's own data, so that the arm is known to get there.

    The one in which gravity loads the joint most, of poses that are not far from the middle of
    the ranges; without a joint the one nearest to the middle.
    """
    q = model.data.q[:: max(1, len(model.data) // _LOOKED_AT)]
    q = np.clip(q, limits.q_low, limits.q_high)
    away = np.abs(q - limits.middle) / np.maximum(0.5 * limits.width, 1e-9)
    worth = -away.mean(axis=1)
    if joint is not None:
        n = model.joints.index(joint)
        still = np.zeros_like(q)
        load = np.abs(model.terms(q, still, still).gravity[:, n])
        worth = load / max(float(model.range.tau_max[n]), 1e-9) + _WAY_COUNTS * worth
    return np.asarray(q[int(np.argmax(worth))])
