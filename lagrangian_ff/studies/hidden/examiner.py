"""Identification and diagnosis as their users call them, to be examined."""

from collections.abc import Mapping
from typing import Any

from lagrangian_ff.diagnosis import add, compare, diagnose
from lagrangian_ff.diagnosis.search.forward import MOST_STEPS
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.recording.motion import Motion

BASE = "vrbfs+fri"
CURVES = ("signature", "blocks")
"""What a finding holds only to be drawn; the study does not keep it."""


class Diagnosis:
    """The package's own, on a base model of the whole first recording.

    Args:
        base: its kernel and effects.
        steps: at most so many missing effects are looked for.
    """

    def __init__(self, base: str = BASE, steps: int = MOST_STEPS) -> None:
        self._base = base
        self._steps = steps

    def identify(self, motion: Motion) -> Model:
        """See Examined."""
        return identify([motion], Settings(model=self._base, train=1.0)).model

    def diagnose(self, model: Model, motion: Motion, confirm: Motion) -> Mapping[str, Any]:
        """See Examined."""
        found = diagnose(model, motion, confirm=confirm, steps=self._steps)
        record: dict[str, Any] = found.record()
        record["findings"] = [
            {key: value for key, value in finding.items() if key not in CURVES}
            for finding in record["findings"]
        ]
        return record

    def add(
        self, model: Model, effect: str, joint: str, shape: Mapping[str, float] | None = None
    ) -> Model:
        """See Examined. What the model has already, in another word, leaves it as it is."""
        try:
            return add(model, effect, joint=joint, shape=shape)
        except ModelError:
            return model

    def errors(self, model: Model, motion: Motion) -> Mapping[str, float]:
        """See Examined."""
        score = compare(model, motion).score
        return dict(zip(model.joints, (float(value) for value in score.rmse), strict=True))
