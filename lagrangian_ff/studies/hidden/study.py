"""The study of hidden effects: each case from the plant to the judgement."""

import time
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from lagrangian_ff import recording
from lagrangian_ff.diagnosis import add, compare, diagnose, diagnosis_record, with_consequences
from lagrangian_ff.diagnosis.results import Found
from lagrangian_ff.diagnosis.search.forward import MOST_STEPS
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import ModelError, UserError
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.studies.hidden.cases import HiddenCase, cases
from lagrangian_ff.studies.hidden.plants import FULL, Built, Stretches, recorded
from lagrangian_ff.studies.hidden.results import HiddenResults
from lagrangian_ff.studies.hidden.verdicts import Truth, claims, judge
from lagrangian_ff.studies.study import Case, Line, Request, Study

BASE = "vrbfs+fri"
CURVES = ("signature", "blocks")
"""Fields of a finding that are only drawn; the study does not keep them."""


@dataclass(frozen=True)
class Answer:
    """What a diagnosis says of a model.

    Attributes:
        findings: which the study judges.
        record: as JSON, which the study keeps on disk.
    """

    findings: Sequence[Found]
    record: Mapping[str, Any]


class Examined(Protocol):
    """Anything that models a motion, names the effects that the model lacks, and adds them."""

    def identify(self, motion: Motion) -> Any:
        """Return a base model of the first recording."""

    def diagnose(self, model: Any, motion: Motion, confirm: Motion) -> Answer:
        """Return what the model lacks."""

    def add(
        self, model: Any, effect: str, joint: str, shape: Mapping[str, float] | None = None
    ) -> Any:
        """Return the model refitted with an effect on a joint; without a shape it is searched."""

    def errors(self, model: Any, motion: Motion) -> Mapping[str, float]:
        """Return the RMS error in N·m by joint on a motion."""


class OwnDiagnosis:
    """This package's identification and diagnosis, with a base model of the first recording.

    Args:
        base: its kernel and effects.
        steps: the largest number of missing effects that are searched.
    """

    def __init__(self, base: str = BASE, steps: int = MOST_STEPS) -> None:
        self._base = base
        self._steps = steps

    def identify(self, motion: Motion) -> Model:
        return identify([motion], Settings(model=self._base, train=1.0)).model

    def diagnose(self, model: Model, motion: Motion, confirm: Motion) -> Answer:
        found = with_consequences(diagnose(model, motion, confirm=confirm, steps=self._steps))
        record = diagnosis_record(found)
        record["findings"] = [
            {key: value for key, value in finding.items() if key not in CURVES}
            for finding in record["findings"]
        ]
        return Answer(found.found, record)

    def add(
        self, model: Model, effect: str, joint: str, shape: Mapping[str, float] | None = None
    ) -> Model:
        """Return the model with the effect, or as it is if it has it by another name."""
        try:
            return add(model, effect, joint=joint, shape=shape)
        except ModelError:
            return model

    def errors(self, model: Model, motion: Motion) -> Mapping[str, float]:
        score = compare(model, motion).score
        return dict(zip(model.joints, (float(value) for value in score.rmse), strict=True))


@dataclass(frozen=True)
class Examination:
    """A case of the study.

    Attributes:
        case: the plant.
        folder: of the study.
        stretches: the parts of each recording.
        examined: who diagnoses.
        keep: keep the recordings in the folder, and use those that are there.
    """

    case: HiddenCase
    folder: Path
    stretches: Stretches
    examined: Examined
    keep: bool = False

    @property
    def name(self) -> str:
        """Return the plant's name."""
        return self.case.name

    def record(self) -> None:
        """Record the plant, and keep that."""
        recorded(self.case, self.folder, self.stretches, keep=True)

    def run(self) -> Mapping[str, Any]:
        """Record the plant, have it diagnosed, and judge the diagnosis.

        Returns:
            The `plant`, the diagnosis's `record`, the `judgement`, the `errors` on the second
            recording of the `base` model, with what was `found` and with the `true` structure,
            and their `ratio`.
        """
        clock, who = Clock(), self.examined
        first, second, plant = recorded(self.case, self.folder, self.stretches, keep=self.keep)
        clock.lap("recording")
        motion, confirm = recording.condition_alike([first, second])
        model = who.identify(motion)
        clock.lap("identification")
        answer = who.diagnose(model, motion, confirm)
        clock.lap("diagnosis")
        lasting = [each for each in plant.hidden if not any(map(_is_event, each.catalogue))]
        errors = self._errors(model, lasting, answer.findings, confirm)
        clock.lap("adding")
        truths = [Truth(tuple(each.catalogue), tuple(each.joints)) for each in plant.hidden]
        return {
            "group": self.case.group,
            "plant": plant.record(),
            "record": answer.record,
            "judgement": judge(truths, answer.findings).record(),
            "errors": {name: dict(by_joint) for name, by_joint in errors.items()},
            "ratio": _ratio(errors, [each.joint for each in lasting]),
            "seconds": clock.laps,
        }

    def _errors(
        self, model: Any, lasting: Sequence[Built], findings: Sequence[Found], confirm: Motion
    ) -> dict[str, Mapping[str, float]]:
        """Return errors by joint of the base model, the true structure, and what was found."""
        who = self.examined
        errors = {"base": who.errors(model, confirm)}
        if lasting and all(each.catalogue for each in lasting):
            true = model
            for each in lasting:
                true = who.add(true, each.catalogue[0], each.joint)
            errors["true"] = who.errors(true, confirm)
        claimed = [one for one in findings if claims(one) and not one.once]
        if claimed:
            found = model
            for claim in claimed:
                found = who.add(found, claim.effect.name, claim.joints[0], claim.shape)
            errors["found"] = who.errors(found, confirm)
        return errors


class Recorded(Case, Protocol):
    """A case that makes recordings."""

    def record(self) -> None:
        """Make the recordings of the case, and keep them."""


@dataclass(frozen=True)
class Recorder:
    """Makes the recordings of a case and does no more."""

    of: Recorded

    @property
    def name(self) -> str:
        """Return the name of the case."""
        return self.of.name

    def run(self) -> Mapping[str, Any]:
        self.of.record()
        return {}


def _is_event(effect: str) -> bool:
    """Return whether an effect is of the recording, as a load taken up: no model is to have it."""
    return EFFECTS[effect].kind == "event"


def _ratio(errors: Mapping[str, Mapping[str, float]], joints: Sequence[str]) -> float | None:
    """Return the error on the hidden effects' joints over that of the true structure.

    Without a claim nothing was added, and the base model's error counts.
    """
    if "true" not in errors:
        return None
    after = errors.get("found", errors["base"])
    total = [sum(by_joint[joint] ** 2 for joint in joints) for by_joint in (after, errors["true"])]
    return float(np.sqrt(total[0] / total[1]))


class Clock:
    """The time that each part of the work took, in s."""

    def __init__(self) -> None:
        self._last = time.monotonic()
        self.laps: dict[str, float] = {}

    def lap(self, name: str) -> None:
        """Book the time since the last lap under a name."""
        now = time.monotonic()
        self.laps[name] = round(now - self._last, 2)
        self._last = now


class DiagnosisStudy(Study):
    """A study of arms that are recorded, and of what a diagnosis says of each.

    Args:
        request: its `models` may name the base model.
        folder: keeps recordings on request.
        base: the base model, if the request names none.
        examined: who diagnoses, picklable; None is this package's diagnosis on the base model.

    Raises:
        UserError: the request names more than one base model.
    """

    takes = frozenset({"models", "keep"})

    def __init__(
        self, request: Request, folder: Path, base: str, examined: Examined | None
    ) -> None:
        super().__init__(request, folder)
        if len(request.models) > 1:
            raise UserError(f"study {self.name} has one base model: name one with --models")
        self._base = request.models[0] if request.models else base
        self._examined = examined or OwnDiagnosis(self._base)

    def identity(self) -> dict[str, Any]:
        """Return what identifies the study, the base model too."""
        return {**super().identity(), "model": self._base}

    @abstractmethod
    def every_case(self) -> Sequence[Recorded]:
        """Return the cases, each of which can also be recorded alone."""

    def recorders(self) -> list[Case]:
        return [Recorder(case) for case in self.named(self.every_case())]


class HiddenStudy(DiagnosisStudy):
    """Is a hidden effect found, and nothing where nothing is hidden?

    Args:
        request, folder, examined: see `DiagnosisStudy`.
        stretches: the parts of each recording.
    """

    name = "hidden"

    def __init__(
        self,
        request: Request,
        folder: Path,
        *,
        examined: Examined | None = None,
        stretches: Stretches = FULL,
    ) -> None:
        super().__init__(request, folder, BASE, examined)
        self._stretches = stretches

    def identity(self) -> dict[str, Any]:
        """Return what identifies the study, the base model and the stretches too."""
        stretches = [list(part) for part in self._stretches.parts]
        return {**super().identity(), "stretches": stretches}

    def every_case(self) -> Sequence[Examination]:
        """Return the cases, clean plants and effects of 10 % first."""
        return [
            Examination(case, self.folder, self._stretches, self._examined, self.request.keep)
            for case in cases(self.request.seed, small=self.request.quick)
        ]

    def results(self, lines: Sequence[Line]) -> HiddenResults:
        return HiddenResults.of(lines)
