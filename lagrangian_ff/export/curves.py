"""A curve as numbers: knots along its coordinates, and the heights of its B-splines."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import Inputs
from lagrangian_ff.effects.curve import FADES, Axis, Curve
from lagrangian_ff.identification.basis import Term

READ = {"position": "q", "velocity": "qd", "acceleration": "qdd", "load": "load"}
"""The state that each coordinate of a curve is."""


@dataclass(frozen=True)
class PortableCurve:
    """A curve on one joint: Σ height × B-spline, which fades beyond the ends, in N·m.

    Attributes:
        effect: its name.
        joint: index of the joint that it is on.
        over: names of states, q, qd, qdd or load, and the joints that they are read of.
        bends: of each coordinate, (K,) where pieces of the B-splines meet.
        heights: N·m, (K + 2,) or (K + 2, L + 2).
        v0: rad/s, the width of the sign that it has; None for none.
    """

    effect: str
    joint: int
    over: tuple[tuple[str, int], ...]
    bends: tuple[tuple[float, ...], ...]
    heights: Floats
    v0: float | None

    @classmethod
    def of(cls, term: Term, curve: Curve, coefficients: Floats, speed: float) -> "PortableCurve":
        """Return the curve of a term with its coefficients (P,); speed is the width of its sign."""
        sizes = [axis.count for axis in curve.axes]
        return cls(
            term.effect.name,
            term.joint,
            tuple((READ[o.kind], term.joint if o.joint is None else o.joint) for o in curve.over),
            tuple(axis.bends for axis in curve.axes),
            (curve.heights @ coefficients).reshape(sizes),
            speed if curve.friction else None,
        )

    def torque(self, x: Inputs) -> Floats:
        """Return (M, N) N·m of states as the effects see them."""
        total, fade = self.heights[None], np.ones(len(x))
        for (name, joint), bends in zip(self.over, self.bends, strict=True):
            at, axis = getattr(x, name)[:, joint], Axis(bends)
            first, weights = axis.weights(at)
            every = np.broadcast_to(total, (len(x), *total.shape[1:]))
            rows = every[np.arange(len(x))[:, None], first[:, None] + np.arange(4)]
            total = np.einsum("mk,mk...->m...", weights, rows)
            fade = fade * axis.fade(at)
        found = np.zeros((len(x), x.joints))
        sign = 1.0 if self.v0 is None else np.tanh(x.qd[:, self.joint] / self.v0)
        found[:, self.joint] = total * fade * sign
        return found

    def record(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {
            "effect": self.effect,
            "joint": self.joint,
            "over": [{"state": name, "joint": joint} for name, joint in self.over],
            "bends": [list(bends) for bends in self.bends],
            "heights": self.heights.tolist(),
            "fades": FADES,
            "v0": self.v0,
        }

    def call(self, number: int) -> str:
        """Return its torque in C, by the tables of its number; see `c/curve.c`."""
        axes = [
            f"{name}[{joint}], curve_{number}_knots_{axis}, {len(bends)}"
            for axis, ((name, joint), bends) in enumerate(zip(self.over, self.bends, strict=True))
        ]
        if len(axes) == 1:
            axes.append("R(0.0), 0, 0")
        sign = "" if self.v0 is None else f" * F(tanh)(qd[{self.joint}] / R({self.v0!r}))"
        return f"over({', '.join(axes)},\n        curve_{number}_heights){sign}"

    def knots(self) -> Iterator[Floats]:
        """Yield (K + 6,) the knots of each coordinate's B-splines, the bends among them."""
        for bends in self.bends:
            yield Axis(bends).knots
