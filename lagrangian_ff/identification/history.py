"""The history of a model, and its JSON, which the model's file holds."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime, timezone
from typing import Any

from lagrangian_ff.identification.records import Identified
from lagrangian_ff.record_json import Json, by_name, given, read


@dataclass(frozen=True)
class Reason:
    """The reason for which an effect was added: in words, and of a finding its evidence in nats."""

    why: str = ""
    verdict: str | None = None
    evidence_gain: float | None = None
    p_value: float | None = None

    def record(self) -> dict[str, Any]:
        """Return the reason for JSON; without a finding it has no evidence."""
        return by_name(self) if self.verdict else given({"why": self.why or None})


@dataclass(frozen=True)
class ErrorChange:
    """The error before and after a step, N·m; None of a model that was just identified."""

    before: float | None = None
    after: float | None = None

    @property
    def left(self) -> float | None:
        """Return the share of the error that is left; None if there was none, or none is known."""
        if self.before is None or self.after is None or not self.before > 0.0:
            return None
        return self.after / self.before

    @property
    def fell(self) -> bool:
        """Return whether the error is known to have fallen."""
        return self.after is not None and self.before is not None and self.after < self.before


@dataclass(frozen=True)
class Step:
    """A step in the history of a model.

    Attributes:
        added: `identified`, or the effect that was added, as `stribeck on joint_3`.
        when: UTC, in ISO format.
        error_before, error_after: N·m, of all joints.  joints: the same of each.
        judged_on: what the error is of, in words.  reason: for the step.
    """

    added: str = ""
    when: str = ""
    error_before: float | None = None
    error_after: float | None = None
    joints: Mapping[str, ErrorChange] = field(default_factory=dict)
    judged_on: str = ""
    reason: Reason = field(default_factory=Reason)

    @classmethod
    def between(
        cls, added: str, before: Identified | None, after: Identified, reason: Reason | None = None
    ) -> "Step":
        """Return the step between two identifications; the first has nothing before it."""
        old = before.score.by_joint if before else {}
        return cls(
            added,
            datetime.now(timezone.utc).isoformat(timespec="seconds"),
            before.score.total if before else None,
            after.score.total,
            {name: ErrorChange(old.get(name), e) for name, e in after.score.by_joint.items()},
            after.judged_on,
            reason or Reason(),
        )

    @classmethod
    def from_record(cls, record: Json) -> "Step":
        """Return the step of a record."""
        return replace(read(cls, record), reason=read(Reason, record))

    def record(self) -> dict[str, Any]:
        """Return the step for JSON."""
        found = by_name(self)
        reason = found.pop("reason")
        return {**found, **reason}


@dataclass(frozen=True)
class History:
    """The steps that made a model.

    Attributes:
        file: the name of the model's file.
        model: kernel and effects, e.g. `chain+fri`.
    """

    file: str
    model: str
    steps: tuple[Step, ...]

    def record(self) -> dict[str, Any]:
        """Return the history for JSON."""
        steps = [step.record() for step in self.steps]
        return {"model": self.file, "model_name": self.model, "steps": steps}
