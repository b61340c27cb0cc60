"""One case from the plant to the judgement."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from lagrangian_ff import recording
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.studies.hidden.cases import Case
from lagrangian_ff.studies.hidden.examined import Examined
from lagrangian_ff.studies.hidden.plants import Stretches
from lagrangian_ff.studies.hidden.store import recorded
from lagrangian_ff.studies.hidden.verdicts import Truth, claims, judge

_Added = tuple[str, str, Mapping[str, float] | None]


def examine(
    case: Case, folder: Path, stretches: Stretches, examined: Examined, *, keep: bool = False
) -> dict[str, Any]:
    """Record a case, have it diagnosed, and judge the diagnosis.

    Args:
        case: what is hidden.
        folder: of the study.
        stretches: what the recordings are made of.
        examined: who diagnoses.
        keep: keep the recordings in the folder, and use those that are there.

    Returns:
        The plant, the diagnosis's record, the judgement, and the errors on the second recording.
    """
    clock = _Clock()
    first, second, plant = recorded(case, folder, stretches, keep=keep)
    clock.lap("recording")
    line: dict[str, Any] = {"group": case.group, "plant": plant}
    motions = recording.condition(first), recording.condition(second)
    line |= _diagnosed(motions, plant, examined, clock)
    return {**line, "seconds": clock.laps}


def truths_of(plant: dict[str, Any]) -> list[Truth]:
    """What was hidden, from the record of a plant."""
    return [Truth(tuple(h["catalogue"]), tuple(h["joints"])) for h in plant["hidden"]]


def _diagnosed(
    motions: tuple[Motion, Motion], plant: dict[str, Any], examined: Examined, clock: "_Clock"
) -> dict[str, Any]:
    model = examined.identify(motions[0])
    clock.lap("identification")
    record = examined.diagnose(model, *motions)
    clock.lap("diagnosis")
    claimed = [
        (finding["effect"], finding["joints"][0], finding.get("shape"))
        for finding in record["findings"]
        if claims(finding) and not _is_event(finding["effect"])
    ]
    lasting = [h for h in plant["hidden"] if not any(map(_is_event, h["catalogue"]))]
    truth = [(h["catalogue"][0], h["joint"], None) for h in lasting if h["catalogue"]]
    joints = [h["joint"] for h in lasting]
    errors = {"base": examined.errors(model, motions[1])}
    if truth and len(truth) == len(joints):
        errors["true"] = examined.errors(_with(examined, model, truth), motions[1])
    if claimed:
        errors["found"] = examined.errors(_with(examined, model, claimed), motions[1])
    clock.lap("adding")
    return {
        "record": record,
        "judgement": asdict(judge(truths_of(plant), record["findings"])),
        "errors": {name: dict(by_joint) for name, by_joint in errors.items()},
        "ratio": _ratio(errors, joints),
    }


def _is_event(effect: str) -> bool:
    """Whether it is of the recording, as a load taken up, so that no model is to have it."""
    return EFFECTS[effect].kind == "event"


def _with(examined: Examined, model: Any, effects: Sequence[_Added]) -> Any:
    """The model with effects added one after the other."""
    for effect, joint, shape in effects:
        model = examined.add(model, effect, joint, shape)
    return model


def _ratio(errors: dict[str, Any], joints: Sequence[str]) -> float | None:
    """The error on the hidden effects' joints, after adding over that of the true structure.

    Without a claim nothing was added, and the base model's error counts.
    """
    if "true" not in errors:
        return None
    after = errors.get("found", errors["base"])
    total = [sum(by_joint[joint] ** 2 for joint in joints) for by_joint in (after, errors["true"])]
    return float(np.sqrt(total[0] / total[1]))


class _Clock:
    """How long each part of the work took, in s."""

    def __init__(self) -> None:
        self._last = time.monotonic()
        self.laps: dict[str, float] = {}

    def lap(self, name: str) -> None:
        """The time since the last lap was spent on this."""
        now = time.monotonic()
        self.laps[name] = round(now - self._last, 2)
        self._last = now
