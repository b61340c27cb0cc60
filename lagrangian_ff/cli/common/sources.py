"""Models and recordings that a command reads, and where a motion leaves what a model knows."""

from argparse import Namespace
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console, progress_bar
from lagrangian_ff.cli.common.options import conditioning_of
from lagrangian_ff.cli.text.model import scaling
from lagrangian_ff.errors import RecordingError, UserError

if TYPE_CHECKING:
    from lagrangian_ff.arrays import Floats
    from lagrangian_ff.identification import Model
    from lagrangian_ff.recording import Conditioning, Inspection, Motion, Recording


MARGIN = 0.05
"""Samples this far outside the range, in parts of it, still count as inside."""
SHORT_SECONDS = 0.25
"""Returns into the range that are shorter do not end a span."""


@dataclass(frozen=True)
class Reading:
    """The motion made of a recording, and what was found in it."""

    inspection: "Inspection"
    motion: "Motion"


def read(path: Path, topic: str | None) -> "Recording":
    """Load a recording; errors are those of `lagrangian_ff.recording.load`."""
    from lagrangian_ff.recording import load

    with progress_bar(f"reading {path.name}") as progress:
        return load(path, topic=topic, progress=progress)


def prepare(
    recordings: Sequence["Recording"], conditioning: "Conditioning", console: Console
) -> list[Reading]:
    """Say what recordings hold, and make them ready as `recording.condition_alike` does."""
    from lagrangian_ff.recording import condition_alike, converted, inspect

    inspections = [inspect(converted(one, conditioning.units)) for one in recordings]
    try:
        with progress_bar("conditioning"):
            motions = condition_alike(recordings, conditioning)
    except RecordingError:
        for inspection in inspections:
            say_inspection(inspection, console)
        raise
    found = []
    for inspection, motion in zip(inspections, motions, strict=True):
        say_inspection(inspection, console)
        for note in motion.notes:
            console.note(note, "  ")
        console.say()
        found.append(Reading(inspection, motion))
    return found


def say_inspection(inspection: "Inspection", console: Console) -> None:
    """Say what a recording holds; the console shows each of its notes once."""
    # Conditioning notes outliers, clipping and doubts again.
    console.say(replace(inspection, notes=(), outliers=(), clipping=(), doubts=()).lines())
    for note in inspection.notes:
        console.note(note, "  ")


def require_same_joints(recordings: Sequence["Recording"]) -> None:
    """Raise RecordingError if joints differ; it names those that all recordings share."""
    first = recordings[0]
    for other in recordings[1:]:
        if set(other.joints) != set(first.joints):
            common = [name for name in first.joints if name in other.joints]
            shared = f"use those of both: --joints {','.join(common)}"
            raise RecordingError(
                f"{first.source} holds the joints {', '.join(first.joints)}, but {other.source} "
                f"holds {', '.join(other.joints)}; "
                f"{shared if common else 'they share none: identify them apart'}"
            )


@dataclass(frozen=True)
class LoadedModel:
    """The model that a command was given, and how recordings are read for it.

    Attributes:
        model: the model.
        path: its file.
        conditioning: of the model, with what the arguments change.
        topic: of bags that hold several.
    """

    model: "Model"
    path: Path
    conditioning: "Conditioning"
    topic: str | None

    @classmethod
    def of(cls, arguments: Namespace, console: Console) -> "LoadedModel":
        """Load the model as `Model.load` does, and say how efforts are scaled.

        Raises:
            UserError: --effort names another kind of effort than the model's.
        """
        from lagrangian_ff.identification import Model

        model = Model.load(arguments.model)
        if arguments.effort not in (None, model.data.effort):
            raise UserError(
                f"--effort {arguments.effort}: {arguments.model} was identified from an effort "
                f"that is {model.data.effort}; leave --effort out, or identify a model from "
                f"recordings whose effort is {arguments.effort}"
            )
        conditioning = conditioning_of(arguments, model.identified.conditioning)
        console.say(scaling(conditioning))
        return cls(model, arguments.model, conditioning, arguments.topic)

    def motions(self, sources: Iterable[Path], console: Console) -> "list[Motion]":
        """Return the motions of the model's joints in recordings; say what each recording holds.

        Raises:
            RecordingError: one cannot be read or made ready.
            ModelError: one lacks a joint of the model; names both lists.
        """
        recordings = [read(source, self.topic) for source in sources]
        for recording in recordings:
            self.model.require_joints(recording.joints, recording.source, self.path)
        chosen = [recording.select(self.model.joints) for recording in recordings]
        return [one.motion for one in prepare(chosen, self.conditioning, console)]


@dataclass(frozen=True)
class OutOfRange:
    """The share of a motion outside the range a model was identified on, by joint.

    Attributes:
        share: of the samples, 0 to 1.
        worst: the joint, quantity and time farthest outside, in words; empty if none is.
        spans: s, from when to when, short returns into the range not counted.
    """

    share: float
    worst: str
    spans: tuple[tuple[float, float], ...]

    def warn(self, what: str, who: str, then: str, console: Console) -> None:
        """Note where `what` lies outside what `who` was identified on, and what follows."""
        if self.share > 0.0:
            console.note(
                f"{self.share:.1%} of the {what} lies outside what {who} was identified on "
                f"({self.worst}){then}"
            )

    def when(self, most: int = 4) -> str:
        """Return the spans in words."""
        shown = [f"{begin:.2f} to {end:.2f} s" for begin, end in self.spans[:most]]
        more = len(self.spans) - most
        return ", ".join(shown) + (f" and {more} more times" if more > 0 else "")


def warn_of_curves(
    model: "Model",
    time: "Floats",
    states: "tuple[Floats, Floats, Floats]",
    what: str,
    console: Console,
) -> None:
    """Note which curves of a model a motion leaves: they are zero there."""
    for words, share in model.curves_outside(*states, time=time).items():
        console.note(
            f"{share:.1%} of the {what} lies outside what {words} has seen: it fades to zero there"
        )


def out_of_range(
    model: "Model", time: "Floats", states: "tuple[Floats, Floats, Floats]"
) -> OutOfRange:
    """Compare a motion, (M,) s and q, qd, qdd, (M, N) each, with the range of a model."""
    import numpy as np

    from lagrangian_ff.nodes.streaming.ranges import excess

    found = excess(model.joints, time, states, model.range, MARGIN)
    times = time[found.outside]
    breaks = np.flatnonzero(~((np.diff(times) >= 0.0) & (np.diff(times) < SHORT_SECONDS)))
    spans = tuple(
        (float(part[0]), float(part[-1])) for part in np.split(times, breaks + 1) if len(part)
    )
    return OutOfRange(float(np.mean(found.outside)) if len(time) else 0.0, found.worst, spans)
