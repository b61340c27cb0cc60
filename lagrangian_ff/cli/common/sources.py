"""From the name of a recording to a motion, telling what was found on the way."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.progress import progress_bar
from lagrangian_ff.errors import RecordingError

if TYPE_CHECKING:
    from lagrangian_ff.identification import Model
    from lagrangian_ff.recording import Conditioning, Inspection, Motion, Recording


@dataclass(frozen=True)
class Reading:
    """A recording, what was found in it, and the motion made of it."""

    recording: "Recording"
    inspection: "Inspection"
    motion: "Motion"


def read(path: Path, topic: str | None) -> "Recording":
    """Load a recording.

    Raises:
        RecordingError: see `lagrangian_ff.recording.load`.
    """
    from lagrangian_ff.recording import load

    with progress_bar(f"reading {path.name}") as progress:
        return load(path, topic=topic, progress=progress)


def prepare(recording: "Recording", conditioning: "Conditioning", console: Console) -> Reading:
    """Tell what a recording holds, and make it ready.

    Raises:
        RecordingError: see `lagrangian_ff.recording.condition`.
    """
    from lagrangian_ff.recording import condition, inspect

    inspection = inspect(recording)
    tell(inspection, console)
    with progress_bar("conditioning"):
        motion = condition(recording, conditioning)
    for note in motion.notes:
        console.note(note)
    console.say()
    return Reading(recording, inspection, motion)


def tell(inspection: "Inspection", console: Console) -> None:
    """What a recording holds; its notes through the console, so that none is shown twice."""
    # Conditioning notes the clipping again.
    console.say(replace(inspection, notes=(), clipping=()).lines())
    for note in inspection.notes:
        console.note(note)


def require_same_joints(recordings: Sequence["Recording"]) -> None:
    """Recordings that are learned from together must be of the same joints.

    Raises:
        RecordingError: they are not; names the joints they share.
    """
    first = recordings[0]
    for other in recordings[1:]:
        if set(other.joints) != set(first.joints):
            common = [name for name in first.joints if name in other.joints]
            raise RecordingError(
                f"{first.source} holds the joints {', '.join(first.joints)}, but {other.source} "
                f"holds {', '.join(other.joints)}; "
                + (f"use those of both: --joints {','.join(common)}" if common
                   else "they share none: identify them apart")
            )  # fmt: skip


def of_model(recording: "Recording", model: "Model", path: Path) -> "Recording":
    """The joints of a model, in its order.

    Raises:
        ModelError: the recording lacks one; names both lists.
    """
    model.require_joints(recording.joints, recording.source, path)
    return recording.select(model.joints)
