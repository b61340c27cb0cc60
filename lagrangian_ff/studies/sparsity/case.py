"""A case: one model of one recording on so many centres."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.identification.blueprint import Blueprint
from lagrangian_ff.identification.solve import solve
from lagrangian_ff.kernels import States
from lagrangian_ff.studies.arm.drive import Drive
from lagrangian_ff.studies.arm.prediction import rms

ASKED = 15_000
"""States whose prediction is timed, as many as validate Figs. 2 and 3."""


@dataclass(frozen=True)
class Sparse:
    """A recording, a model, and what its kernel is built on.

    Attributes:
        drive: where the recording comes from.
        model: kernel and effects.
        settings: of the identification but for the model.
        centres: how many states the kernel is built on.
        exact: whether these are also all that is learned from; else every training sample is.
    """

    drive: Drive
    model: str
    settings: Settings
    centres: int
    exact: bool

    @property
    def name(self) -> str:
        """As in `speed05-vrbfs+fri-landmarks0100`, and `…-samples0100` where the fit is exact."""
        kind = "samples" if self.exact else "landmarks"
        return f"{self.drive.name}-{self.model}-{kind}{self.centres:04d}"

    def run(self) -> Mapping[str, Any]:
        """Identify, judge and time.

        Returns:
            `rmse`, the error on motion held out in N·m (all joints), `relative`, over the torque's
            own rms; `learned_from`, how many samples; processor seconds `fitting` the coefficients
            once everything is chosen, and `predicting` 15,000 states.
        """
        motion = self.drive.motion()
        settings = replace(self.settings, model=self.model, landmarks=self.centres)
        if self.exact:
            settings = replace(settings, samples=self.centres, landmarks=0)
        found = identify(motion, settings)
        blueprint = Blueprint.of(found.model)
        data = blueprint.data
        inputs = Inputs.of(States.of(data.q, data.qd, data.qdd), data.time, data.segment)
        asked = States.of(motion.q[:ASKED], motion.qd[:ASKED], motion.qdd[:ASKED])
        times = ASKED / len(asked)
        error = rms(found.held_out.tau - found.predicted)
        return {
            "speed": self.drive.speed,
            "model": self.model,
            "centres": self.centres,
            "exact": self.exact,
            "learned_from": len(found.training),
            "rmse": float(rms(error)),
            "relative": float(rms(error) / rms(rms(found.held_out.tau))),
            "fitting": _processor_seconds(lambda: solve(blueprint, inputs)),
            "predicting": times
            * _processor_seconds(lambda: found.model.predict(asked.q, asked.qd, asked.qdd)),
        }


def _processor_seconds(work: Callable[[], object]) -> float:
    """Of the faster of two calls: other work on the machine must not count, nor compiling."""
    spent = []
    for _ in range(2):
        began = time.process_time()
        work()
        spent.append(time.process_time() - began)
    return min(spent)
