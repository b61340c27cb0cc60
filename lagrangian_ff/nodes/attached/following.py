"""Whether an arm follows the motion that was sent, and how many seconds it runs ahead of it."""

from dataclasses import dataclass, field

import numpy as np

from lagrangian_ff.arrays import Floats

NEAR = 0.3  # rad from a motion at which it still counts as followed
OFF = 0.05  # rad from a motion from which on it shows that the arm is ahead of it, or behind
LEFT = 0.4  # of that distance which is left where it is ahead
EARLY = np.arange(-8, 13) * 0.05
"""The s by which an arm may be ahead of the motion that are tried; below zero it is late."""
ON_TIME = int(np.argmin(np.abs(EARLY)))


@dataclass
class Seen:
    """Counts how far an arm is from its motion, at two looks a second.

    Attributes:
        astray: the last looks at which it was far from the motion, without a break.
        off: looks at which it was not on the motion.
        apart: (K,) rad², for each of `EARLY` the sum over all looks of its squared distance from
            where the motion would be, were it ahead by that.
    """

    astray: int = 0
    off: int = 0
    apart: Floats = field(default_factory=lambda: np.zeros(len(EARLY)))

    @property
    def followed(self) -> bool:
        """Return whether the arm followed the motion so far."""
        return self.astray <= 1

    def follows(self, away: Floats) -> bool:
        """Count a look at distances (N,) from the motion, rad; return whether it is followed."""
        self.astray = self.astray + 1 if away.max() > NEAR else 0
        return self.followed

    def lead(self, away: Floats) -> float:
        """Count a look, and return the s by which the arm is ahead; 0 if that is not clear.

        Args:
            away: (K, N) rad from where the motion would be, were it ahead by each of `EARLY`.
        """
        worst = away.max(axis=1)
        self.off += int(worst[ON_TIME] > OFF)
        self.apart += worst**2
        best = int(np.argmin(self.apart))
        inside = 0 < best < len(EARLY) - 1  # an arm that stands is ever later
        clear = inside and self.off > 1 and self.apart[best] < LEFT**2 * self.apart[ON_TIME]
        return float(EARLY[best]) if clear else 0.0
