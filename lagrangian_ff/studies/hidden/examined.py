"""What is examined: anything that can do what identification and diagnosis do."""

from collections.abc import Mapping
from typing import Any, Protocol

from lagrangian_ff.recording.motion import Motion


class Examined(Protocol):
    """Anything that models a motion, names what the model lacks, and adds it."""

    def identify(self, motion: Motion) -> Any:
        """A base model of the first recording."""

    def diagnose(self, model: Any, motion: Motion, confirm: Motion) -> Mapping[str, Any]:
        """The record of what the model lacks; see `lagrangian_ff diagnose --json`."""

    def add(
        self, model: Any, effect: str, joint: str, shape: Mapping[str, float] | None = None
    ) -> Any:
        """The model with an effect on a joint, fitted again; without a shape it is searched."""

    def errors(self, model: Any, motion: Motion) -> Mapping[str, float]:
        """RMS error in N·m by joint on a motion."""
