"""The low-pass of recordings, for signals of which only the past is known.

Recordings are filtered forward and backward by a Butterworth low-pass, which squares its gain and
leaves no delay. The same filter passed twice forward has the same gain at every frequency, so that
residuals keep their size, and delays all signals alike.
"""

from math import ceil

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.recording.filtering import settling

Floats = NDArray[np.float64]

STEP = 0.5
"""Longest step, in units of 1 / (2π bandwidth): the Taylor series below is exact to 1e-9 there."""
TERMS = 12


class CausalFilter:
    """A Butterworth low-pass twice in a row, with the derivatives of what it lets through.

    The state is the output and its derivatives, x' = A x + B u in time scaled by 2π bandwidth, and
    is solved for inputs that run straight between samples, however they are spaced.

    Args:
        order: of the low-pass.
        bandwidth: Hz, where it passes half (1/√2 twice).

    Attributes:
        delay: s by which slow signals come late.
        settled: s after which what was before the start is forgotten.
    """

    def __init__(self, order: int, bandwidth: float) -> None:
        angles = np.pi * (np.arange(1, 2 * order, 2) + order) / (2 * order)
        once = np.poly(np.exp(1j * angles)).real  # the poles lie on a half circle
        twice = np.convolve(once, once)
        size = len(twice) - 1
        self._scale = 2.0 * np.pi * bandwidth
        # Below the state stand the input and its slope.
        self._system = np.zeros((size + 2, size + 2))
        self._system[: size - 1, 1:size] = np.eye(size - 1)
        self._system[size - 1, :size] = -twice[:0:-1]
        self._system[size - 1, size] = 1.0
        self._system[size, size + 1] = 1.0
        self._size = size
        self._state: Floats = np.zeros((size + 2, 0))
        self._step, self._advance = 0.0, np.eye(size + 2)
        self.delay = float(twice[-2] / twice[-1]) / self._scale
        self.settled = 2.0 * settling(order, bandwidth)

    def start(self, values: Floats) -> None:
        """Begin with signals (S,) that are taken to have been constant."""
        self._state = np.zeros((self._size + 2, len(values)))
        self._state[0] = self._state[self._size] = values

    def take(self, passed: float, values: Floats) -> None:
        """The next sample (S,), so many s after the last."""
        scaled = passed * self._scale
        count = max(1, ceil(scaled / STEP))
        self._state[self._size + 1] = (values - self._state[self._size]) / scaled
        advance = self._over(scaled / count)
        for _ in range(count):
            self._state = advance @ self._state

    def output(self) -> tuple[Floats, Floats, Floats]:
        """(S,) the signals, and their first and second derivative by time."""
        change = self._system[1] @ self._state
        return (
            self._state[0].copy(),
            self._scale * (self._system[0] @ self._state),
            self._scale**2 * change,
        )

    def _over(self, step: float) -> Floats:
        """The matrix exponential of a step in scaled time; steady clocks need it once."""
        if step != self._step:
            term = advance = np.eye(self._size + 2)
            for k in range(1, TERMS + 1):
                term = term @ self._system * (step / k)
                advance = advance + term
            self._step, self._advance = step, advance
        return self._advance
