"""The paper's low-pass filter and the derivatives of filtered signals (section IV-B)."""

from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Floats

REACH = 4
"""Samples to either side that a derivative uses."""

# Central differences of eighth order over nine samples, for offsets 0 to 4. At half the Nyquist
# frequency they are 3.0 % and 0.7 % low, at a fifth of it below 0.01 %; differences over three
# samples would be 36 % and 19 % low there, and 6.5 % and 3.2 %.
_FIRST = np.array([0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
_SECOND = np.array([-205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])


@dataclass(frozen=True)
class Butterworth:
    """A low-pass that is passed forward and backward: no delay, and the gain squared.

    Attributes:
        order: of the low-pass.
        bandwidth: Hz, where its gain squared is 1/2.
        rate: Hz, at which signals are sampled.
    """

    order: int
    bandwidth: float
    rate: float

    def gain(self, count: int) -> Floats:
        """Return the gain squared at the frequencies of the transform of `count` samples."""
        # The bilinear transform bends frequencies; at the bandwidth it is exact.
        bent = np.tan(np.pi * np.minimum(np.fft.rfftfreq(count), 0.5 - 1e-9))
        ratio = bent / np.tan(np.pi * self.bandwidth / self.rate)
        return np.asarray(1.0 / (1.0 + ratio ** (2 * self.order)))

    def zero_phase(self, values: Floats, padding: int) -> Floats:
        """Return (M,) filtered, M > padding.

        `padding` samples are added at each end by point reflection, which keeps value and slope,
        and removed again.
        """
        begin = 2.0 * values[0] - values[padding:0:-1]
        end = 2.0 * values[-1] - values[-2 : -2 - padding : -1]
        padded = np.concatenate([begin, values, end])
        # Up to a 32nd longer: lengths that are few small factors transform many times faster.
        unit = 1 << max(0, len(padded).bit_length() - 6)
        padded = np.pad(padded, (0, -len(padded) % unit), mode="edge")
        # Less a line, which the low-pass keeps, the periodic continuation has no step.
        line = np.linspace(padded[0], padded[-1], len(padded))
        waves = np.fft.rfft(padded - line)
        waves *= self.gain(len(padded))
        filtered = np.fft.irfft(waves, len(padded)) + line
        return np.asarray(filtered[padding : padding + len(values)])


def settling(order: int, bandwidth: float) -> float:
    """Return the time, s, in which the filter settles to 1/1000.

    From the slowest pole of the analogue Butterworth filter, whose real part is
    −2π bandwidth sin(π / (2 order)).
    """
    decay = 2 * np.pi * bandwidth * np.sin(np.pi / (2 * order))
    return float(-np.log(1e-3) / decay)


def derivatives(values: Floats, period: float) -> tuple[Floats, Floats]:
    """Return the first and second derivative of (M,) uniform samples but REACH at each end."""
    first = np.concatenate([-_FIRST[:0:-1], _FIRST]) / period
    second = np.concatenate([_SECOND[:0:-1], _SECOND]) / period**2
    return (np.correlate(values, first, mode="valid"), np.correlate(values, second, mode="valid"))
