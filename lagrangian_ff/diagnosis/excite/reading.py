"""The inputs that effects read of a motion under design."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis.excite.splines import Splines
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.kernels import States


@dataclass(frozen=True)
class Reading:
    """Reads what some effects need, and no more: the model's load of a whole motion costs most.

    Attributes:
        model: that predicts load and torque.
        terms: the effects.
        splines: the motions.  index: (S,) the samples of their time that are looked at.
        sign_speed: (N,) rad/s.
    """

    model: Model
    terms: Sequence[Term]
    splines: Splines
    index: Ints
    sign_speed: Floats

    def of(self, control: Floats) -> Inputs:
        """Return the samples of the motion of control points (K, N)."""
        x = self.of_ways([rate @ control for rate in self.rates], self.terms)
        has = self._remembers and _of_whole(self.terms)
        return self.loaded(x) if self.uses and not has else x

    def of_ways(self, ways: Sequence[Floats], terms: Sequence[Term]) -> Inputs:
        """Return the samples of a motion, with a load only where effects need that of the past.

        Args:
            ways: q, qd and qdd at `rates`.  terms: the effects.
        """
        states, time = States.of(*ways), self.splines.time[self._rows]
        x = Inputs.of(states, time, np.zeros(len(states), dtype=np.int64))
        x = replace(x, sign_speed=self.sign_speed)
        if not self._remembers:
            return x
        return (self.loaded(x) if _of_whole(terms) else x).take(self.index)

    def loaded(self, x: Inputs) -> Inputs:
        """Return inputs with the model's load and torque."""
        read = self.model.inputs(x.q, x.qd, x.qdd, time=x.time, segment=x.segment)
        read = self.model.with_torque(read)
        return replace(x, load=read.load, torque=read.torque, rotor=read.rotor)

    @cached_property
    def rates(self) -> tuple[Floats, Floats, Floats]:
        """Return (R, K) each: q, qd and qdd by the control points, where effects need them."""
        q, qd, qdd, _ = self.splines.rates
        return q[self._rows], qd[self._rows], qdd[self._rows]

    @cached_property
    def uses(self) -> bool:
        """Return whether an effect uses the model's load or torque."""
        return any(term.effect.uses for term in self.terms)

    @cached_property
    def _remembers(self) -> bool:
        return any(term.effect.remembers for term in self.terms)

    @property
    def _rows(self) -> Ints | slice:
        return slice(None) if self._remembers else self.index


def _of_whole(terms: Sequence[Term]) -> bool:
    """Return whether effects use the load of the past, or the torque, which has a past itself."""
    return any(
        "torque" in one.effect.uses or bool(one.effect.uses and one.effect.remembers)
        for one in terms
    )
