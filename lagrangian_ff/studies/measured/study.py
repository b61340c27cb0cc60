"""The study of measured recordings: each case from the files to errors or verdicts."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lagrangian_ff.diagnosis import compare, diagnose, diagnosis_record, with_consequences
from lagrangian_ff.errors import UserError
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.identification.records import Score
from lagrangian_ff.identification.samples import decimated
from lagrangian_ff.identification.spec import parse
from lagrangian_ff.recording.motion import Motion, concatenate
from lagrangian_ff.studies.measured.alone import alone, peak_memory
from lagrangian_ff.studies.measured.known import Known, Split, known_arms
from lagrangian_ff.studies.measured.reading import contacts, motions
from lagrangian_ff.studies.measured.results import DIAGNOSIS, KINEMATICS, STANDARD, MeasuredResults
from lagrangian_ff.studies.measured.standard import StandardWay
from lagrangian_ff.studies.study import Line, Request, Study

DEFAULT = Settings.model
USUAL, QUICK = (DEFAULT, "motor+fri", "vrbfs+fri", "rbfs+fri"), (DEFAULT,)
CURVES = ("signature", "blocks")
"""Fields of a finding that are only drawn; the study does not keep them."""


@dataclass(frozen=True)
class MeasuredCase:
    """A case: what one way makes of one use of an arm's recordings.

    Attributes:
        known: the arm.  split: the use.
        way: the name of a model, with `KINEMATICS` behind it if it is given these; `STANDARD`; or
            `DIAGNOSIS` of the model.
        model: that of the way.
    """

    known: Known
    split: Split
    way: str
    model: str = ""

    @property
    def name(self) -> str:
        """Return a name such as `kr300/AB-C/auto+fri`."""
        return f"{self.known.name}/{self.split.name}/{self.way}"

    def run(self) -> Mapping[str, Any]:
        """Do the case in a process of its own.

        Returns:
            `arm`, what is `used` of it, `split` and `way`; of a model `joints`, `rmse`, `nmse` on
            the motion to test on, and what it is in `model`; of a diagnosis its `record` and the
            `contacts` that there were; `cpu`, processor seconds of each step, and `memory`, GB at
            most.
        """
        work = {STANDARD: _standard, DIAGNOSIS: _diagnosis}.get(self.way, _model)
        told = {
            "arm": self.known.name,
            "used": self.known.used,
            "split": self.split.name,
            "way": self.way,
        }
        return {**told, **alone(work, self)}


class _Clock:
    """The processor time that each step took, in s."""

    def __init__(self) -> None:
        self._last = time.process_time()
        self.laps: dict[str, float] = {}

    def lap(self, name: str) -> None:
        """Book the time since the last lap under a name."""
        now = time.process_time()
        self.laps[name] = round(now - self._last, 2)
        self._last = now

    def record(self) -> dict[str, Any]:
        """Return times and memory."""
        return {"cpu": self.laps, "memory": round(peak_memory(), 3)}


def _standard(case: MeasuredCase) -> dict[str, Any]:
    known, split, clock = case.known, case.split, _Clock()
    kinematics = known.kinematics
    if kinematics is None:
        raise UserError(f"{known.name}: no kinematics, which the standard way needs")
    train = _whole(motions(known, split.train))
    test = _whole(motions(known, split.test, train))
    clock.lap("reading")
    urdf = kinematics.text(known.joints)
    found = StandardWay.identified(urdf, kinematics.gravity, train, kinematics.source)
    clock.lap("identify")
    score = Score.of(test.joints, test.tau, found.predict(test))
    return {**_errors(score), "model": f"{len(found.base)} parameters", **clock.record()}


def _model(case: MeasuredCase) -> dict[str, Any]:
    clock = _Clock()
    model = _identified(case, clock)
    test = _whole(motions(case.known, case.split.test, model.data))
    score = compare(model, test).score
    clock.lap("compare")
    return {**_errors(score), "model": model.name, **clock.record()}


def _identified(case: MeasuredCase, clock: _Clock) -> Model:
    known = case.known
    train = motions(known, case.split.train)
    clock.lap("reading")
    robot = None
    if case.way.endswith(KINEMATICS) and known.kinematics is not None:
        robot = known.kinematics.robot(known.joints)
    found = identify(train, Settings(model=case.model, train=1.0), mechanism=robot)
    clock.lap("identify")
    return found.model


def _diagnosis(case: MeasuredCase) -> dict[str, Any]:
    known, split, clock = case.known, case.split, _Clock()
    model = _identified(case, clock)
    search, confirm = (motions(known, parts, model.data) for parts in (split.search, split.confirm))
    clock.lap("reading again")
    found = diagnose(model, search, confirm=confirm)
    clock.lap("diagnose")
    record = diagnosis_record(with_consequences(found))
    clock.lap("consequences")
    record["findings"] = [
        {key: value for key, value in one.items() if key not in CURVES}
        for one in record["findings"]
    ]
    pulses = [pulse for part in split.search for pulse in _pulses(known, part.recording)]
    return {"record": record, "contacts": pulses, "model": model.name, **clock.record()}


def _pulses(known: Known, recording: str) -> list[tuple[float, float]]:
    """Return the contacts that a recording's effort does not have."""
    source = known.sources[recording]
    return contacts(known, source) if source.layout.effort_minus else []


def _whole(parts: Sequence[Motion]) -> Motion:
    return concatenate([decimated(one) for one in parts])


def _errors(score: Score) -> dict[str, Any]:
    return {"joints": score.joints, "rmse": score.rmse.tolist(), "nmse": score.nmse.tolist()}


class MeasuredStudy(Study):
    """How good are models and diagnoses on measured arms?

    Raises:
        UserError: no folder is named, or what is known of an arm in it cannot be read.
        ModelError: there is no such model.
    """

    name = "measured"
    takes = frozenset({"models", "recordings", "known"})

    def __init__(self, request: Request, folder: Path) -> None:
        if request.recordings is None:
            raise UserError(
                "study measured needs the folder of the recordings: lagrangian_ff study measured "
                "FOLDER [--known FOLDER]"
            )
        self.arms = known_arms(request.recordings, request.known)
        if request.only in {arm.name for arm in self.arms}:
            request = replace(request, only=f"{request.only}/*")
        super().__init__(request, folder)
        usual = QUICK if request.quick else USUAL
        self.models = tuple(dict.fromkeys(request.models or usual))
        for model in self.models:
            parse(model)

    def identity(self) -> dict[str, Any]:
        """Return what identifies the study, the folder of the recordings too."""
        return {**super().identity(), "recordings": str(self.request.recordings)}

    def current(self, line: Line) -> bool:
        """Return whether the arm's recordings are still used as they were for a line."""
        return any((arm.name, arm.used) == (line["arm"], line["used"]) for arm in self.arms)

    def every_case(self) -> Sequence[MeasuredCase]:
        """Return the cases arm by arm: the standard way, models, the diagnosis of the first."""
        found = []
        for arm in self.arms:
            for split in arm.splits[:1] if self.request.quick else arm.splits:
                ways = [(model, model) for model in self.models]
                if arm.kinematics is not None:
                    first = self.models[0]
                    ways = [(STANDARD, ""), (f"{first}{KINEMATICS}", first), *ways]
                if not self.request.quick and (split.confirm or arm.contact[0]):
                    ways.append((DIAGNOSIS, self.models[0]))
                found += [MeasuredCase(arm, split, way, model) for way, model in ways]
        return found

    def results(self, lines: Sequence[Line]) -> MeasuredResults:
        return MeasuredResults.of(lines, self.arms)
