"""What a stream of torques may do at most."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


def clamp(tau: Floats, limit: Floats) -> tuple[Floats, Flags]:
    """Torques within ±limit, and where they were not."""
    return np.minimum(np.maximum(tau, -limit), limit), np.abs(tau) > limit


def slew(previous: Floats, wanted: Floats, rate: Floats, dt: float) -> tuple[Floats, Flags]:
    """From `previous` towards `wanted` by at most rate·dt; and which joints were held back."""
    step, flagged = clamp(wanted - previous, rate * dt)
    return previous + step, flagged


class Ramp:
    """A gain between 0 and 1 that takes `up` seconds to rise and `down` seconds to fall."""

    def __init__(self, up: float, down: float) -> None:
        self.value = 0.0
        self.up = up
        self.down = down

    def move(self, on: bool, dt: float) -> float:
        """Towards 1 or 0 for dt seconds; the new gain."""
        if on:
            self.value = min(1.0, self.value + (dt / self.up if self.up > 0.0 else 1.0))
        else:
            self.value = max(0.0, self.value - (dt / self.down if self.down > 0.0 else 1.0))
        return self.value
