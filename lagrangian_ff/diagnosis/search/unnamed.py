"""Torques that depend on a coordinate in any smooth way: rivals without a name.

An effect that the catalogue does not have pushes some wrong name up. Where a free curve over one
coordinate explains clearly more than every known effect does, the honest finding is that curve's
coordinate, not a name.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.search.tones import Tone
from lagrangian_ff.effects import Inputs

Floats = NDArray[np.float64]

KNOTS, PLACE_KNOTS = 9, 5


@dataclass(frozen=True)
class Dependence:
    """A piecewise linear torque over a coordinate, times the smoothed sign where it is friction.

    Attributes:
        name: for records.
        coordinate: in words, after "depends on".
        reads: the coordinate (M,) of the inputs, for a joint.
        knots: (K,) where the curve may bend.
        friction: whether it changes sign with the direction of motion.
    """

    name: str
    coordinate: str
    reads: Callable[[Inputs, int], Floats]
    knots: tuple[float, ...]
    friction: bool

    def columns(self, x: Inputs, joint: int) -> Floats:
        """(S, K) hat functions over the coordinate."""
        out = _hats(self.reads(x, joint), self.knots)
        return out * x.sign(joint)[:, None] if self.friction else out


@dataclass(frozen=True)
class Place:
    """Friction that depends on where two joints stand, in any smooth way: a hose, a cable.

    Attributes:
        name, coordinate: as of a dependence.
        other: the second joint.
        knots: (K,) of each of the two.
    """

    name: str
    coordinate: str
    other: int
    knots: tuple[tuple[float, ...], tuple[float, ...]]

    def columns(self, x: Inputs, joint: int) -> Floats:
        """(S, K K) products of hat functions, times the smoothed sign."""
        mine, its = (
            _hats(x.q[:, n], knots)
            for n, knots in zip((joint, self.other), self.knots, strict=True)
        )
        both = mine[:, :, None] * its[:, None, :]
        return np.asarray(both.reshape(len(x), -1) * x.sign(joint)[:, None])


Unnamed = Dependence | Place | Tone


def _hats(values: Floats, knots: Sequence[float]) -> Floats:
    """(S, K) piecewise linear functions, each one at its knot and zero at the others."""
    bends = np.asarray(knots)
    at = np.clip(values, bends[0], bends[-1])
    place = np.clip(np.searchsorted(bends, at, side="right") - 1, 0, len(bends) - 2)
    share = (at - bends[place]) / (bends[place + 1] - bends[place])
    out = np.zeros((len(at), len(bends)))
    rows = np.arange(len(at))
    out[rows, place] = 1.0 - share
    out[rows, place + 1] = share
    return out


def told(words: str, joints: Sequence[str]) -> str:
    """A dependence in words, the joints by their names instead of their numbers."""
    return re.sub(r"\bjoint (\d+)\b", lambda match: joints[int(match.group(1))], words)


def since_reversal(x: Inputs, joint: int) -> Floats:
    """(M,) s since the joint's velocity last changed sign, or since the motion began."""
    out = np.zeros(len(x))
    whole = x.whole or x
    elapsed = np.zeros(len(whole))
    for piece in whole.pieces():
        time = whole.time[piece]
        if not np.isfinite(time).all():
            elapsed[piece] = np.inf
            continue
        turned = np.flatnonzero(np.diff(np.signbit(whole.qd[piece, joint]))) + 1
        last = np.zeros(len(time), dtype=np.int64)
        last[turned] = turned
        elapsed[piece] = time - time[np.maximum.accumulate(last)]
    out[:] = elapsed if x.index is None else elapsed[x.index]
    return np.minimum(out, 10.0)


def _own(kind: str) -> Callable[[Inputs, int], Floats]:
    return lambda x, joint: np.asarray(getattr(x, kind)[:, joint])


def _of(kind: str, other: int) -> Callable[[Inputs, int], Floats]:
    return lambda x, joint: np.asarray(getattr(x, kind)[:, other])


def _time(x: Inputs, joint: int) -> Floats:
    return np.minimum(x.time, 1e9)


def _make(
    name: str, words: str, reads: Callable[[Inputs, int], Floats], friction: bool
) -> Callable[[Inputs, int], Iterator[Dependence]]:
    def make(x: Inputs, joint: int) -> Iterator[Dependence]:
        knots = _knots(reads(x, joint))
        if len(knots) >= 3:
            yield Dependence(name, words, reads, knots, friction)

    return make


def _neighbours(
    name: str, words: str, kind: str, friction: bool
) -> Callable[[Inputs, int], Iterator[Dependence]]:
    def make(x: Inputs, joint: int) -> Iterator[Dependence]:
        for other in range(x.joints):
            reads = _of(kind, other)
            knots = _knots(reads(x, joint))
            if other != joint and len(knots) >= 3:
                label = words.replace("#", str(other))
                yield Dependence(f"{name} {other}", label, reads, knots, friction)

    return make


def _places(x: Inputs, joint: int) -> Iterator[Place]:
    mine = _knots(x.q[:, joint], PLACE_KNOTS)
    for other in range(x.joints):
        its = _knots(x.q[:, other], PLACE_KNOTS)
        if other != joint and len(mine) >= 3 and len(its) >= 3:
            words = f"its position and that of joint {other}, changing sign with direction"
            yield Place(f"friction over its position and joint {other}", words, other, (mine, its))


def _knots(values: Floats, count: int = KNOTS) -> tuple[float, ...]:
    knots = np.unique(np.quantile(values, np.linspace(0.0, 1.0, count)))
    width = float(np.ptp(values))
    keep = np.concatenate([[True], np.diff(knots) > 1e-6 * width]) if width > 0.0 else [True]
    return tuple(float(v) for v in knots[keep])


UNNAMED: tuple[Callable[[Inputs, int], Iterator[Unnamed]], ...] = (
    _make("velocity", "velocity", _own("qd"), False),
    _make("position", "position", _own("q"), False),
    _make("acceleration", "acceleration", _own("qdd"), False),
    _make("time", "time", _time, False),
    _make("friction over position", "position, changing sign with direction", _own("q"), True),
    _make("friction over time", "time, changing sign with direction", _time, True),
    _make("friction over load", "load, changing sign with direction", _own("load"), True),
    _make("friction over acceleration", "acceleration, changing sign with direction",
          _own("qdd"), True),
    _make("since reversal", "time since reversal, changing sign with direction",
          since_reversal, True),
    _neighbours("velocity of joint", "velocity of joint #", "qd", False),
    _neighbours("friction over position of joint",
                "position of joint #, changing sign with direction", "q", True),
    _places,
)  # fmt: skip
"""Every dependence without a name; a new one joins here."""
