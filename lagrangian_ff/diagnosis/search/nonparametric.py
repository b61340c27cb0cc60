"""Nonparametric alternatives to the effects: splines over a coordinate, and sinusoids of time.

An effect that is not in the catalogue makes a wrong effect look good. Where a spline over one
coordinate explains clearly more than every effect does, the finding is that coordinate.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.search.products import WITH_SIGN, Product
from lagrangian_ff.effects import Curve, Inputs, Over, curve_over
from lagrangian_ff.sampling import usual_step

KNOTS, PRODUCT_KNOTS = 9, 5
BAND = (1.0, 10.0)
"""Hz between which a sinusoid is searched: slower ones are the motion's own."""
SHORTEST, PADDED = 200, 4


@dataclass(frozen=True)
class Spline:
    """A piecewise linear torque over a coordinate, times the smoothed sign where it is friction.

    Attributes:
        name: for records.
        coordinate: in words, after "depends on".
        reads: returns the coordinate (M,) of the inputs, for a joint.
        knots: (K,) where the curve may bend.
        friction: whether it changes sign with the direction of motion.
        of: the coordinate as a curve of a model has it; None for time.
    """

    name: str
    coordinate: str
    reads: Callable[[Inputs, int], Floats]
    knots: tuple[float, ...]
    friction: bool
    of: Over | None = None

    def over(self, joint: int) -> tuple[Over, ...]:
        """Return the coordinate; none where it is time."""
        return (self.of,) if self.of else ()

    def columns(self, x: Inputs, joint: int) -> Floats:
        """Return hat functions (S, K) over the coordinate."""
        out = _hats(self.reads(x, joint), self.knots)
        return out * x.sign(joint)[:, None] if self.friction else out


@dataclass(frozen=True)
class SplineProduct:
    """Friction over the positions of two joints, as of a hose or a cable.

    Attributes:
        name, coordinate: as of a spline.  other: the second joint.
        knots: (K,) of each of the two.
    """

    name: str
    coordinate: str
    other: int
    knots: tuple[tuple[float, ...], tuple[float, ...]]
    friction = True

    def over(self, joint: int) -> tuple[Over, ...]:
        """Return both positions."""
        return Over("position"), Over("position", self.other)

    def columns(self, x: Inputs, joint: int) -> Floats:
        """Return products (S, K K) of hat functions, times the smoothed sign."""
        mine, its = (
            _hats(x.q[:, n], knots)
            for n, knots in zip((joint, self.other), self.knots, strict=True)
        )
        both = mine[:, :, None] * its[:, None, :]
        return np.asarray(both.reshape(len(x), -1) * x.sign(joint)[:, None])


@dataclass(frozen=True)
class Sinusoid:
    """A torque that swings at one frequency, as of a floor, a pump or a controller.

    Attributes:
        name, coordinate: as of a spline.  frequency: Hz.
    """

    name: str
    coordinate: str
    frequency: float
    friction = False

    def over(self, joint: int) -> tuple[Over, ...]:
        """Return none: no curve of a model is over time."""
        return ()

    def columns(self, x: Inputs, joint: int) -> Floats:
        """Return cosine and sine (S, 2) of time; zero where time is not known."""
        angle = 2.0 * np.pi * self.frequency * np.where(np.isfinite(x.time), x.time, 0.0)
        waves = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return np.asarray(np.where(np.isfinite(x.time)[:, None], waves, 0.0))


Alternative = Spline | SplineProduct | Sinusoid | Product


def curve_of(source: Alternative, joint: int, joints: Sequence[str]) -> Curve | None:
    """Return the curve that takes an alternative on a joint into a model; None if none does.

    None is over time, nor over more than two coordinates.
    """
    over = source.over(joint)
    named = [one if one.joint is None else replace(one, name=joints[one.joint]) for one in over]
    return curve_over(named, friction=source.friction) if 1 <= len(named) <= 2 else None


def _hats(values: Floats, knots: Sequence[float]) -> Floats:
    """Return piecewise linear functions (S, K), each 1 at its knot and 0 at the others."""
    bends = np.asarray(knots)
    at = np.clip(values, bends[0], bends[-1])
    place = np.clip(np.searchsorted(bends, at, side="right") - 1, 0, len(bends) - 2)
    share = (at - bends[place]) / (bends[place + 1] - bends[place])
    out = np.zeros((len(at), len(bends)))
    rows = np.arange(len(at))
    out[rows, place] = 1.0 - share
    out[rows, place + 1] = share
    return out


def with_joint_names(words: str, joints: Sequence[str]) -> str:
    """Return words about a coordinate with the names of joints instead of their numbers."""
    return re.sub(r"\bjoint (\d+)\b", lambda match: joints[int(match.group(1))], words)


def _time(x: Inputs, joint: int) -> Floats:
    return np.minimum(x.time, 1e9)


def _make(
    words: str, of: Over | None, *, friction: bool = False, name: str = ""
) -> Callable[[Inputs, int], Iterator[Spline]]:
    """Return the maker of a spline over a coordinate, or time; named after it if not otherwise."""
    reads = of.read if of else _time
    name = name or (f"friction over {words}" if friction else words)
    coordinate = f"{words}, {WITH_SIGN}" if friction else words

    def make(x: Inputs, joint: int) -> Iterator[Spline]:
        knots = _knots(reads(x, joint))
        if len(knots) >= 3:
            yield Spline(name, coordinate, reads, knots, friction, of)

    return make


def _neighbours(kind: str, *, friction: bool = False) -> Callable[[Inputs, int], Iterator[Spline]]:
    """Return the maker of splines over a coordinate of each other joint."""

    def make(x: Inputs, joint: int) -> Iterator[Spline]:
        for other in range(x.joints):
            if other != joint:
                of = f"{kind} of joint {other}"
                yield from _make(of, Over(kind, other), friction=friction)(x, joint)

    return make


def _products(x: Inputs, joint: int) -> Iterator[SplineProduct]:
    mine = _knots(x.q[:, joint], PRODUCT_KNOTS)
    for other in range(x.joints):
        its = _knots(x.q[:, other], PRODUCT_KNOTS)
        if other != joint and len(mine) >= 3 and len(its) >= 3:
            name = f"friction over its position and joint {other}"
            words = f"its position and that of joint {other}, {WITH_SIGN}"
            yield SplineProduct(name, words, other, (mine, its))


def _knots(values: Floats, count: int = KNOTS) -> tuple[float, ...]:
    knots = np.unique(np.quantile(values, np.linspace(0.0, 1.0, count)))
    width = float(np.ptp(values))
    keep = np.concatenate([[True], np.diff(knots) > 1e-6 * width]) if width > 0.0 else [True]
    return tuple(float(v) for v in knots[keep])


ALTERNATIVES: tuple[Callable[[Inputs, int], Iterator[Alternative]], ...] = (
    _make("velocity", Over("velocity")),
    _make("position", Over("position")),
    _make("acceleration", Over("acceleration")),
    _make("time", None),
    _make("position", Over("position"), friction=True),
    _make("time", None, friction=True),
    _make("load", Over("load"), friction=True),
    _make("acceleration", Over("acceleration"), friction=True),
    _make("time since reversal", Over("reversal"), friction=True, name="since reversal"),
    _neighbours("velocity"),
    _neighbours("position", friction=True),
    _products,
)
"""Every alternative but the sinusoids; a new one joins here."""


def sinusoids(time: Floats, residual: Floats) -> list[Sinusoid]:
    """Return a sinusoid for each joint, at the frequency where its residual swings most.

    Args:
        time: (M,) s, evenly spaced.  residual: (M, N) N·m.
    """
    step = usual_step(time)
    if not 0.0 < step < np.inf or len(time) < SHORTEST:
        return []
    window = np.hanning(len(time))[:, None]
    size = PADDED * len(time)
    power = np.abs(np.fft.rfft((residual - residual.mean(axis=0)) * window, size, axis=0)) ** 2
    frequency = np.fft.rfftfreq(size, step)
    band = (frequency >= BAND[0]) & (frequency <= min(BAND[1], 0.4 / step))
    found = []
    for joint in range(residual.shape[1]):
        best = float(frequency[band][np.argmax(power[band, joint])])
        found.append(Sinusoid(f"tone of {best:.2f} Hz", f"time, swinging at {best:.2f} Hz", best))
    return found
