"""How far, how fast and how hard each joint may move."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.motion_range import MotionRange

Floats = NDArray[np.float64]

MARGIN = 0.05
"""Kept from the ends of a range, in parts of it."""


@dataclass(frozen=True)
class Limits:
    """What a motion must not leave.

    Attributes:
        q_low, q_high: (N,) rad.  qd_max: (N,) rad/s.  qdd_max: (N,) rad/s².
    """

    q_low: Floats
    q_high: Floats
    qd_max: Floats
    qdd_max: Floats

    @classmethod
    def within(
        cls, known: "MotionRange | Limits", joints: Sequence[str], margin: float = MARGIN
    ) -> "Limits":
        """A margin inside what is known: the range of a model, or the limits of an arm.

        Raises:
            ModelError: values that are not finite or leave no room at all; names the joint.
        """
        low, high, speed, hardness = (
            np.array(getattr(known, field.name), dtype=np.float64) for field in fields(cls)
        )
        for n, name in enumerate(joints):
            if not (np.isfinite([low[n], high[n], speed[n], hardness[n]]).all()):
                raise ModelError(f"{name}: its limits are not finite numbers")
            if high[n] < low[n] or speed[n] < 0.0 or hardness[n] < 0.0:
                raise ModelError(
                    f"{name}: limits of {low[n]:g} to {high[n]:g} rad, {speed[n]:g} rad/s and "
                    f"{hardness[n]:g} rad/s² leave no room to move"
                )
        inside = margin * (high - low)
        return cls(low + inside, high - inside, (1 - margin) * speed, (1 - margin) * hardness)

    @property
    def middle(self) -> Floats:
        """(N,) rad."""
        return 0.5 * (self.q_low + self.q_high)

    @property
    def width(self) -> Floats:
        """(N,) rad."""
        return self.q_high - self.q_low

    def around(self, pose: Floats, reach: float) -> "Limits":
        """The positions within this share of the way from a pose (N,) to the limits."""
        return Limits(
            pose + reach * (self.q_low - pose),
            pose + reach * (self.q_high - pose),
            self.qd_max,
            self.qdd_max,
        )

    def gentler(self, factor: float) -> "Limits":
        """The same positions at this factor of the speed, and its square of the acceleration."""
        return Limits(self.q_low, self.q_high, factor * self.qd_max, factor**2 * self.qdd_max)
