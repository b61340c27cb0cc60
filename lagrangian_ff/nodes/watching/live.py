"""The torques a model predicts for live states, including effects with a memory."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification import Model
from lagrangian_ff.kernels import States
from lagrangian_ff.nodes.watching.states import State

MEMORY = 300
"""States that effects with a memory look back on."""
BEHIND = 2
"""States by which the prediction waits for effects with derivatives: those need both sides."""


@dataclass(frozen=True)
class Judged:
    """A state and the torque (N,) N·m predicted for it."""

    state: State
    predicted: Floats

    @property
    def residual(self) -> Floats:
        """Return measured minus predicted, (N,) N·m."""
        return np.asarray(self.state.tau - self.predicted)


class LivePrediction:
    """Predicts in the order of time.

    Effects that come or go with the time since a recording began (warm-up, drift, payload,
    contact) are taken as settled: the start of the motion is unknown.

    Args:
        model: of the states' joints.

    Attributes:
        waits: states by which it is late.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self._remembering = [
            (term, model.coefficients[place])
            for term, place in model.basis.slices()
            if term.effect.remembers
        ]
        self._past: deque[_Past] = deque(maxlen=MEMORY)
        self.waits = BEHIND if self._remembering else 0

    def take(self, states: Sequence[State]) -> list[Judged]:
        """Take the newest states, oldest first, and return those whose prediction is ready."""
        if not states:
            return []
        x = _stacked(states)
        predicted = self._model.predict(x.q, x.qd, x.qdd)
        if not self._remembering:
            return [Judged(*each) for each in zip(states, predicted, strict=True)]
        inputs = replace(self._model.inputs(x.q, x.qd, x.qdd), torque=predicted)
        without = predicted - self._remembered(inputs)
        fresh = zip(states, inputs.load, predicted, without, strict=True)
        self._past.extend(_Past(*each) for each in fresh)
        return self._ready(len(states))

    def _ready(self, fresh: int) -> list[Judged]:
        """Return the states with BEHIND states after them, given the number of new ones."""
        past = list(self._past)
        inputs = Inputs.of(
            _stacked([each.state for each in past]),
            np.array([(each.state.at - past[0].state.at) / 1e9 for each in past]),
            np.array([each.state.segment for each in past]),
            np.stack([each.load for each in past]),
            np.stack([each.predicted for each in past]),
            self._model.basis.sign_speed(len(self._model.joints)),
        )
        remembered = self._remembered(inputs)
        last = len(past) - BEHIND
        # What waited when the stream was interrupted has lost its future.
        return [
            Judged(past[k].state, past[k].without + remembered[k])
            for k in range(max(0, last - fresh), last)
            if past[k].state.segment == past[k + BEHIND].state.segment
        ]

    def _remembered(self, inputs: Inputs) -> Floats:
        """Return the torque (M, N) N·m of all effects with a memory."""
        torque = np.zeros_like(inputs.q)
        for term, coefficients in self._remembering:
            torque[:, term.joint] += term.columns(inputs) @ coefficients
        return torque


@dataclass(frozen=True)
class _Past:
    """A state, its load, and two predictions for it: settled, and without memory."""

    state: State
    load: Floats
    predicted: Floats
    without: Floats


def _stacked(states: Sequence[State]) -> States:
    return States.of(*(np.stack([getattr(s, name) for s in states]) for name in ("q", "qd", "qdd")))
