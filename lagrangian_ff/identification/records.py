"""The findings of an identification, and their JSON.

A model's file holds the JSON. That of an older version may lack fields: they get their defaults.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import isnan, nan
from typing import Any

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.identification.predicting import MotionRange
from lagrangian_ff.identification.settings import Settings
from lagrangian_ff.record_json import Json, by_name, given, read
from lagrangian_ff.recording.motion import Conditioning

NEEDED = (
    "model", "samples", "training_seconds", "seconds", "judged_on", "held_out_seconds", "joints",
    "rmse", "nmse", "effects", "hyperparameters",
)  # fmt: skip
"""Fields without which a record describes no model."""


@dataclass(frozen=True)
class Score:
    """Errors of predicted torque, per joint.

    Attributes:
        joints: names.  rmse: (N,) N·m, root mean square.
        nmse: (N,) mean squared error over the variance of the measured torque: 0 is perfect, 1 is
            no better than the mean; NaN where the torque did not vary.
    """

    joints: tuple[str, ...] = ()
    rmse: Floats = field(default_factory=lambda: np.zeros(0))
    nmse: Floats = field(default_factory=lambda: np.zeros(0))

    @classmethod
    def of(cls, joints: tuple[str, ...], measured: Floats, predicted: Floats) -> "Score":
        """Return the errors of predicted torques (M, N) in N·m."""
        squared = np.mean((measured - predicted) ** 2, axis=0)
        variance = np.var(measured, axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            nmse = np.where(variance > 0.0, squared / variance, np.nan)
        return cls(joints, np.sqrt(squared), nmse)

    @classmethod
    def from_record(cls, record: Json) -> "Score":
        """Return the errors of a record; a number that JSON could not hold is NaN."""
        joints: Mapping[str, Json] = record.get("joints", {})
        rmse, nmse = (
            np.array([one[name] for one in joints.values()], dtype=np.float64)
            for name in ("rmse", "nmse")
        )
        return cls(tuple(joints), rmse, nmse)

    @property
    def by_joint(self) -> dict[str, float]:
        """Return the root mean square error of each joint by name, N·m."""
        return dict(zip(self.joints, self.rmse.tolist(), strict=True))

    @property
    def total(self) -> float:
        """Return the root mean square of the joints' errors, N·m."""
        return float(np.sqrt(np.mean(self.rmse**2))) if len(self.rmse) else nan

    @property
    def mean_nmse(self) -> float:
        """Return the mean nmse of the joints whose torque varied; NaN if none did."""
        return float(np.nanmean(self.nmse)) if np.isfinite(self.nmse).any() else nan

    def record(self) -> dict[str, object]:
        """Return for JSON the errors by joint, their root mean square, and the mean nmse."""
        return {
            "joints": {
                name: {"rmse": float(r), "nmse": float(n)}
                for name, r, n in zip(self.joints, self.rmse, self.nmse, strict=True)
            },
            "rmse": self.total,
            "nmse": self.mean_nmse,
        }


@dataclass(frozen=True)
class Estimate:
    """A parameter in its unit, with the ends of its 90 % interval; NaN if that is not known."""

    value: float = nan
    low: float = nan
    high: float = nan
    unit: str = ""

    @property
    def bounded(self) -> bool:
        """Return whether it has an interval."""
        return not isnan(self.low)


@dataclass(frozen=True)
class FittedEffect:
    """An effect on a joint, with the numbers found.

    Attributes:
        effect, joint: names.
        formula: its torque, with parameters and shapes by their names.  parameters: by name.
        shape: the numbers that the torque is not linear in, by name.
        shape_words: the same for people.
    """

    effect: str = ""
    joint: str = ""
    formula: str = ""
    parameters: Mapping[str, Estimate] = field(default_factory=dict)
    shape: Mapping[str, float] = field(default_factory=dict)
    shape_words: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class MassCheck:
    """The states of the training motion at which the mass matrix is not positive definite.

    Attributes:
        defined: whether the joints share a Lagrangian, and so a mass matrix; only then have the
            others a value.
        states: number checked.  share: of them, where it is not positive definite.
        least: the least eigenvalue, kg·m².
        joint: the main one in the direction of that.
        where: from and to, rad, of each joint in the states where it is not positive definite.
        words: the finding, or why there is none.
    """

    defined: bool = False
    states: int = 0
    share: float = nan
    least: float = nan
    joint: str = ""
    where: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    words: str = ""

    def record(self) -> dict[str, Any]:
        """Return the finding for JSON."""
        return by_name(self) if self.defined else {"defined": False, "words": self.words}


@dataclass(frozen=True)
class JointOutliers:
    """Torques of a joint that count less than half: their share, 0 to 1.

    Attributes:
        threshold: N·m, beyond which the loss is linear.
        held_out_median: N·m, of the error on motion held out.
    """

    share: float = nan
    threshold: float = nan
    held_out_median: float | None = None


@dataclass(frozen=True)
class Stretch:
    """A time without interruption; begin and length in s."""

    joint: str = ""
    begin: float = nan
    seconds: float = nan


@dataclass(frozen=True)
class Outliers:
    """Torques that count less than half in a robust fit.

    Attributes:
        share: of all torques, 0 to 1.  joints: the same by joint.
        longest: the longest stretch of them; None without outliers.
        rmse_of_others: N·m on blocks left out; None if there are no others.
        words: the finding.
    """

    share: float = nan
    joints: Mapping[str, JointOutliers] = field(default_factory=dict)
    longest: Stretch | None = None
    rmse_of_others: float | None = None
    words: str = ""

    @property
    def medians(self) -> dict[str, float]:
        """Return by joint the median error on motion held out, N·m."""
        return given({name: one.held_out_median for name, one in self.joints.items()})


@dataclass(frozen=True)
class Calibration:
    """Factors by joint on the standard deviations, for intervals that hold with this `level`.

    Attributes:
        factor: for the whole model.  quick: for its cheap form; None if that cannot be made.
    """

    level: float = nan
    factor: Mapping[str, float] = field(default_factory=dict)
    quick: Mapping[str, float] | None = None


@dataclass(frozen=True)
class Tried:
    """A kernel and a scale of torques that were tried on some samples.

    Attributes:
        evidence: log evidence in nats; of a choice by evidence its negative, to be minimised.
        validation: the error on blocks left out; None in a choice by evidence.
    """

    kernel: str = ""
    scale: str = ""
    samples: int = 0
    evidence: float = nan
    validation: float | None = None

    def record(self) -> dict[str, Any]:
        """Return the candidate for JSON."""
        return given(by_name(self))


@dataclass(frozen=True)
class KnownMechanism:
    """The part of an arm's mechanics that was known before.

    Attributes:
        kind: `urdf` for rigid bodies, which alone have what follows; or `linkage`.
        mass: kg, of all bodies.  prismatic: joints that slide.
        still: joints that were not recorded and are taken to stand at zero.
    """

    kind: str = ""
    name: str = ""
    mass: float | None = None
    prismatic: tuple[str, ...] | None = None
    still: tuple[str, ...] | None = None

    def record(self) -> dict[str, Any]:
        """Return the mechanism for JSON."""
        return given(by_name(self))


@dataclass(frozen=True, kw_only=True)
class Identified:
    """The findings of an identification.

    Attributes:
        model: kernel and effects, e.g. `chain+fri`.
        score: the errors on motion not learned from.  judged_on: what that motion is, in words.
        validation: the errors on blocks of the training motion, left out in turn.
        samples: number learned from.  landmarks: inducing points; 0 for an exact model.
        seconds: of computing.  training_seconds, held_out_seconds: of motion.
        hyperparameters: by name, one number for each joint, or one for all.
        scale: `common` if all torques have one unit, else `joint`.
        range: of the training motion.  notes: remarks of reading, conditioning and fitting.
        conditioning: of the recordings; None if they were not conditioned here.
        tried: candidates in the choice of kernel and scale; None of a model with an effect added.
        sources: the recordings.  outliers: of a robust fit.
        missing: fields of `NEEDED` that the record lacks.
    """

    model: str = ""
    score: Score = field(default_factory=Score)
    judged_on: str = ""
    validation: Score = field(default_factory=Score)
    samples: int = 0
    landmarks: int = 0
    seconds: float = nan
    training_seconds: float = nan
    held_out_seconds: float = nan
    hyperparameters: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    scale: str = ""
    effects: tuple[FittedEffect, ...] = ()
    mass_matrix: MassCheck = field(default_factory=MassCheck)
    uncertainty: Calibration | None = None
    log_evidence: float = nan
    range: MotionRange | None = None
    settings: Settings = field(default_factory=Settings)
    conditioning: Conditioning | None = None
    notes: tuple[str, ...] = ()
    mechanism: KnownMechanism | None = None
    sources: tuple[str, ...] = ()
    tried: tuple[Tried, ...] | None = None
    outliers: Outliers | None = None
    missing: tuple[str, ...] = ()

    @classmethod
    def from_record(cls, record: Json) -> "Identified":
        """Return the findings of a record."""
        found = read(
            cls,
            record,
            validation=Score.from_record,
            hyperparameters=lambda held: {name: _numbers(value) for name, value in held.items()},
            range=MotionRange.from_record,
            conditioning=Conditioning.from_record,
        )
        missing = tuple(name for name in NEEDED if name not in record)
        return replace(found, score=Score.from_record(record), missing=missing)

    def record(self) -> dict[str, Any]:
        """Return the findings for JSON."""
        found = by_name(self)
        del found["missing"]
        found["conditioning"] = found["conditioning"] or {}
        found["hyperparameters"] = {
            name: number_or_list(values) for name, values in self.hyperparameters.items()
        }
        return {"model": found.pop("model"), **found.pop("score"), **given(found)}


def _numbers(value: float | list[float]) -> tuple[float, ...]:
    return tuple(value) if isinstance(value, list) else (value,)


def number_or_list(values: tuple[float, ...]) -> float | list[float]:
    """Return a hyperparameter for JSON: the number of all joints, or a list with one for each."""
    return list(values) if len(values) > 1 else values[0]
