"""A model and the recordings it is held against, made ready as those it was identified from."""

from argparse import Namespace
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.options import conditioning_of
from lagrangian_ff.cli.common.sources import of_model, prepare, read
from lagrangian_ff.cli.text.model import scaling

if TYPE_CHECKING:
    from lagrangian_ff.identification import Model
    from lagrangian_ff.recording import Conditioning, Motion


@dataclass(frozen=True)
class Held:
    """The model of a command's arguments, and how recordings are read for it.

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
    def of(cls, arguments: Namespace, console: Console) -> "Held":
        """Load the model, and tell how efforts are scaled.

        Raises:
            ModelError: see `lagrangian_ff.identification.Model.load`.
        """
        from lagrangian_ff.identification import Model
        from lagrangian_ff.recording import Conditioning

        model = Model.load(arguments.model)
        conditioning = conditioning_of(
            arguments, Conditioning.from_record(model.record.get("conditioning"))
        )
        console.say(scaling(conditioning.record()))
        return cls(model, arguments.model, conditioning, arguments.topic)

    def motions(self, sources: Iterable[Path], console: Console) -> "list[Motion]":
        """The motions of recordings, each told as it is read.

        Raises:
            RecordingError: one cannot be read or made ready.
            ModelError: one lacks a joint of the model.
        """
        recordings = [of_model(read(one, self.topic), self.model, self.path) for one in sources]
        return [prepare(one, self.conditioning, console).motion for one in recordings]
