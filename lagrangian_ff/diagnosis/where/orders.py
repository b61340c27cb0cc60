"""Waves of the residual over the joint's angle.

An order is the number of waves in one turn of the joint. Cogging, eccentric gears and tooth mesh
show as lines, whatever the speed and direction. Amplitudes are least squares at the measured
angles, so that the uneven sampling of a motion does no harm.
"""

from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Flags, Floats
from lagrangian_ff.diagnosis.where.series import ResidualSeries, block_orders
from lagrangian_ff.record_json import by_name

SAMPLES = 6000
HIGHEST = 200.0
FINEST_STEP = 0.25
SHUFFLES = 60
CHANCE = 0.05
"""Probability, over all orders, that a residual not tied to the angle shows a line."""
MOST_LINES = 5
LOWEST_LINE, LEAST_WAVES = 3.0, 2.0
"""Waves a turn, and within the motion, that a line has at least: fewer are a slow dependence on
position, which gravity or a spring may cause."""
NAMED_SHARE = 0.05
"""Of the residual's variance: a line that holds less is not worth a sentence."""
CHUNK = 100
"""Orders computed at once, so that memory stays bounded."""


@dataclass(frozen=True)
class Line:
    """A wave that stands out.

    Attributes:
        order: waves a turn.  amplitude: N·m.
    """

    order: float
    amplitude: float


@dataclass(frozen=True)
class Spectrum:
    """One joint's residual over its angle.

    Attributes:
        joint: its name.
        resolution: the difference of orders that shows: one over the turns the joint travelled.
        order: (K,) waves a turn.  amplitude: (K,) N·m.
        noise: (K,) N·m, below which 95 % lie where the residual is not tied to the angle.
        lines: those that stand out, the strongest first.
        spread: N·m, rms of the residual without its mean.
    """

    joint: str
    resolution: float
    order: Floats
    amplitude: Floats
    noise: Floats
    lines: tuple[Line, ...]
    spread: float

    def share(self, line: Line) -> float:
        """Return the share of a line in the residual's variance."""
        return min(1.0, 0.5 * (line.amplitude / self.spread) ** 2)

    @property
    def named(self) -> Line | None:
        """Return the strongest line; None if it is not worth a sentence."""
        return next((one for one in self.lines[:1] if self.share(one) >= NAMED_SHARE), None)

    def record(self) -> dict[str, object]:
        """Return the spectrum for JSON."""
        found = by_name(self)
        del found["spread"]
        lines = [{**by_name(line), "share": self.share(line)} for line in self.lines]
        return {**found, "lines": lines}


def order_spectrum(series: ResidualSeries, joint: int, seed: int = 0) -> Spectrum | None:
    """Return the amplitude at each order up to 200.

    None if the joint hardly moves or errs, or the motion is too short.

    Args:
        seed: of the random orders of blocks that give the noise.
    """
    small = series.thinned(SAMPLES)
    q, r = small.motion.q[:, joint], small.residual[:, joint]
    travel = float(np.ptp(q))
    resolution = 2.0 * np.pi / max(travel, 1e-9)
    r = r - r.mean()
    spread = float(np.sqrt(np.mean(r**2)))
    if series.too_short or resolution > 0.2 * HIGHEST or not spread > 0.0:
        return None
    order = np.arange(max(1.0, resolution), HIGHEST, max(FINEST_STEP, 0.25 * resolution))
    residuals = np.concatenate([r[None], r[block_orders(small.motion.time, SHUFFLES, seed)]])
    chunks = (order[k : k + CHUNK] for k in range(0, len(order), CHUNK))
    amplitude = np.concatenate([_amplitudes(q, residuals, chunk) for chunk in chunks], axis=1)
    measured, chance = amplitude[0], amplitude[1:]
    noise = np.quantile(chance, 1.0 - CHANCE, axis=0)
    usual = np.maximum(np.median(chance, axis=0), 1e-300)
    limit = float(np.quantile((chance / usual).max(axis=1), 1.0 - CHANCE))
    strong = (measured / usual > limit) & (order > max(LOWEST_LINE, LEAST_WAVES * resolution))
    places = _peaks(order, measured, strong, resolution)
    lines = tuple(_refined(q, r, order, k) for k in places)
    name = series.motion.joints[joint]
    return Spectrum(name, resolution, order, measured, noise, lines, spread)


def _amplitudes(q: Floats, residuals: Floats, order: Floats) -> Floats:
    """Return (S, K) amplitudes of a cos(k q) + b sin(k q) in (S, M) residuals without mean.

    The orders are evenly spaced, so that each wave is the one before, turned on.
    """
    angle = np.empty((len(order), len(q)), dtype=np.complex128)
    angle[0] = np.exp(1j * order[0] * q)
    turn = np.exp(1j * (order[-1] - order[0]) / max(1, len(order) - 1) * q)
    for k in range(1, len(order)):
        np.multiply(angle[k - 1], turn, out=angle[k])
    angle -= angle.mean(axis=1, keepdims=True)
    c, s = angle.real.copy(), angle.imag.copy()
    cc, ss, cs = (c * c).sum(axis=1), (s * s).sum(axis=1), (c * s).sum(axis=1)
    rc, rs = residuals @ c.T, residuals @ s.T
    det = np.maximum(cc * ss - cs * cs, 1e-12 * (cc + ss) ** 2 + 1e-300)
    return np.hypot((ss * rc - cs * rs) / det, (cc * rs - cs * rc) / det)


def _refined(q: Floats, r: Floats, order: Floats, place: int) -> Line:
    """Return the top of a peak, between the orders that were tried."""
    around = order[place] + np.linspace(-1.0, 1.0, 81) * (order[1] - order[0])
    amplitude = _amplitudes(q, r[None], around)[0]
    top = int(np.argmax(amplitude))
    return Line(float(around[top]), float(amplitude[top]))


def _peaks(order: Floats, amplitude: Floats, strong: Flags, resolution: float) -> tuple[int, ...]:
    """Return the places of the strong orders, highest first, one within each resolution."""
    lines: list[int] = []
    for k in np.argsort(-amplitude):
        apart = all(abs(order[k] - order[other]) > 1.5 * resolution for other in lines)
        if strong[k] and apart and len(lines) < MOST_LINES:
            lines.append(int(k))
    return tuple(lines)
