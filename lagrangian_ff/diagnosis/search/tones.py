"""Torques that swing at one frequency, whatever the arm does."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs

Floats = NDArray[np.float64]

TONES = (1.0, 10.0)
"""Hz between which a tone is looked for: slower ones are the motion's own."""
SHORTEST_TONE, PADDED = 200, 4


@dataclass(frozen=True)
class Tone:
    """A torque that swings at one frequency, whatever the arm does: a floor, a pump, a controller.

    Attributes:
        name, coordinate: as of a dependence.
        frequency: Hz.
    """

    name: str
    coordinate: str
    frequency: float

    def columns(self, x: Inputs, joint: int) -> Floats:
        """(S, 2) cosine and sine of time; zero where nothing is known of time."""
        angle = 2.0 * np.pi * self.frequency * np.where(np.isfinite(x.time), x.time, 0.0)
        waves = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return np.asarray(np.where(np.isfinite(x.time)[:, None], waves, 0.0))


def tones(time: Floats, left: Floats) -> list[Tone]:
    """The frequency at which what a model leaves over swings most, of each joint.

    Args:
        time: (M,) s, evenly spaced.
        left: (M, N) N·m.
    """
    step = float(np.median(np.diff(time))) if len(time) > 1 else np.inf
    if not np.isfinite(step) or len(time) < SHORTEST_TONE:
        return []
    window = np.hanning(len(time))[:, None]
    size = PADDED * len(time)
    power = np.abs(np.fft.rfft((left - left.mean(axis=0)) * window, size, axis=0)) ** 2
    frequency = np.fft.rfftfreq(size, step)
    band = (frequency >= TONES[0]) & (frequency <= min(TONES[1], 0.4 / step))
    found = []
    for joint in range(left.shape[1]):
        best = float(frequency[band][np.argmax(power[band, joint])])
        found.append(Tone(f"tone of {best:.2f} Hz", f"time, swinging at {best:.2f} Hz", best))
    return found
