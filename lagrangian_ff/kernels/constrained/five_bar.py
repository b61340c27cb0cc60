"""The planar five-bar: two driven cranks whose forearms meet at a hand."""

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.kernels.constrained.linkage import Linkage


class FiveBar(Linkage):
    """Cranks at (0, 0) and (base, 0), forearms that meet above the base.

    Angles count from the x axis. Cut open at the hand, it is a tree of four joints: the angle
    of each crank, and that of its forearm to it: left crank, left elbow, right crank, right elbow.

    Args:
        base: m between the cranks' axes.
        cranks, forearms: m, left and right.
        joints: names of the two driven joints.
    """

    name = "five-bar"

    def __init__(
        self, base: float, cranks: tuple[float, float], forearms: tuple[float, float],
        joints: tuple[str, str] = ("left", "right"),
    ) -> None:  # fmt: skip
        self.joints = joints
        self._axes = np.array([[0.0, 0.0], [base, 0.0]])
        self._cranks, self._forearms = np.array(cranks), np.array(forearms)

    def positions(self, q: Floats) -> Floats:
        """Return the angles of cranks and forearms; NaN if the forearms do not reach each other."""
        forearms = self._forearm_angles(q)
        between = np.angle(np.exp(1j * (forearms - q)))
        return np.stack([q[:, 0], between[:, 0], q[:, 1], between[:, 1]], axis=1)

    def jacobian(self, q: Floats) -> Floats:
        forearms = self._forearm_angles(q)
        # The hand is on both arms. Columns of ∂hand/∂angle: left forearm, minus right forearm;
        # and the cranks.
        passive = _across(forearms, self._forearms) * np.array([1.0, -1.0])
        active = _across(q, self._cranks) * np.array([-1.0, 1.0])
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = np.empty((len(q), 2, 2))
            inverse[:, 0, 0], inverse[:, 0, 1] = passive[:, 1, 1], -passive[:, 0, 1]
            inverse[:, 1, 0], inverse[:, 1, 1] = -passive[:, 1, 0], passive[:, 0, 0]
            determinant = inverse[:, 0, 0] * inverse[:, 1, 1] - inverse[:, 0, 1] * inverse[:, 1, 0]
            turned = inverse @ active / determinant[:, None, None]
        out = np.zeros((len(q), 4, 2))
        out[:, 0, 0] = out[:, 2, 1] = 1.0
        out[:, 1], out[:, 3] = turned[:, 0], turned[:, 1]
        out[:, 1, 0] -= 1.0
        out[:, 3, 1] -= 1.0
        return out

    def _forearm_angles(self, q: Floats) -> Floats:
        """Return (M, 2) rad of the forearms: two circles about the elbows meet at the hand."""
        tips = np.stack([np.cos(q), np.sin(q)], axis=2) * self._cranks[None, :, None]
        elbows = self._axes[None] + tips
        apart = elbows[:, 1] - elbows[:, 0]
        distance = np.linalg.norm(apart, axis=1)
        left, right = self._forearms
        with np.errstate(divide="ignore", invalid="ignore"):
            along = (distance**2 + left**2 - right**2) / (2.0 * distance)
            above = np.sqrt(left**2 - along**2)
            unit = apart / distance[:, None]
            normal = np.stack([-unit[:, 1], unit[:, 0]], axis=1)
            hand = elbows[:, 0] + along[:, None] * unit + above[:, None] * normal
        arms = hand[:, None, :] - elbows
        return np.arctan2(arms[:, :, 1], arms[:, :, 0])


def _across(angle: Floats, length: Floats) -> Floats:
    """Return (M, 2, K) the derivative of each rod's end (x, y) by its angle (M, K)."""
    return np.stack([-np.sin(angle) * length, np.cos(angle) * length], axis=1)
