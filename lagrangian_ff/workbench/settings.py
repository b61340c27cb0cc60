"""What a user chose: how recordings are read, and which model is learned."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from lagrangian_ff.identification.settings import usual_model
from lagrangian_ff.recording.motion import TOTAL, Conditioning

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis import Diagnosis
    from lagrangian_ff.diagnosis.preflight import Check
    from lagrangian_ff.recording import Motion, Recording

Record = dict[str, Any]
AUTO, URDF = "auto", "urdf"


@dataclass(frozen=True)
class Choice:
    """A model that can be chosen.

    Attributes:
        name: of its kernel; `URDF` for the bodies of a description.
        title, meaning: for people.
    """

    name: str
    title: str
    meaning: str


CHOICES = (
    Choice(AUTO, "Automatic", "A serial arm of unknown masses: chain, or chain_rbf where that "
           "surely predicts better. Right for most arms."),
    Choice("chain", "Serial arm (chain)", "Each link's energy depends on the joints before it. "
           "Learns from the least motion."),
    Choice("energy", "Any arm (energy)", "Kinetic energy quadratic in velocity, gravity apart. "
           "For parallel arms and closed chains, too."),
    Choice("vrbfs", "One Lagrangian (vrbfs)", "The paper's: one smooth Lagrangian for all joints. "
           "Assumes less, needs more motion."),
    Choice("rbfs", "No structure (rbfs)", "Any smooth torque of position, velocity and "
           "acceleration: no mechanics, to compare with."),
)  # fmt: skip


def choices(urdf: str) -> list[Choice]:
    """Return the models that can be chosen.

    Args:
        urdf: the file of a description; empty for none.
    """
    if not urdf:
        return list(CHOICES)
    name = urdf.replace("\\", "/").rpartition("/")[2]
    meaning = "Its masses are corrected from the recordings, and a kernel learns the rest."
    return [*CHOICES, Choice(URDF, f"Bodies of {name}", meaning)]


def model_name(choice: str, effort: str) -> str:
    """Return the name of the model of a choice, as `identify --model` has it.

    Args:
        effort: what the recorded effort holds.
    """
    usual = usual_model(effort)
    return usual if choice in (AUTO, URDF) else usual.replace(AUTO, choice)


@dataclass(frozen=True)
class Reading:
    """How the recordings of a session are read: as usual, but for the remedies that were taken.

    Attributes:
        effort: what their effort holds.
        effort_delay: s by which it comes later than the position.
        scales: by file and joint, N·m per unit of effort where it is not 1.
    """

    effort: str = TOTAL
    effort_delay: float = 0.0
    scales: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def ready(
        self,
        files: Sequence[str],
        recordings: Sequence["Recording"],
        before: Conditioning | None = None,
    ) -> "list[Motion]":
        """Return the motions of recordings, made ready together, each with its own scale.

        Args:
            files: that the recordings were read from.
            before: the settings of a model, which these recordings follow but for their scales.
        """
        from lagrangian_ff.recording import condition_alike

        settings = before or Conditioning(effort=self.effort, effort_delay=self.effort_delay)
        given = [self.scale(file, one.joints) for file, one in zip(files, recordings, strict=True)]
        scaled = [
            replace(one, effort=one.effort * [scale.get(joint, 1.0) for joint in one.joints])
            for one, scale in zip(recordings, given, strict=True)
        ]
        motions = condition_alike(scaled, replace(settings, effort_scale={}))
        return [
            replace(motion, conditioning={**motion.conditioning, "effort_scale": scale})
            for motion, scale in zip(motions, given, strict=True)
        ]

    def scale(self, file: str, joints: Sequence[str]) -> dict[str, float]:
        """Return the scales of some joints in a file, where they are not 1."""
        return {joint: f for joint, f in self.scales.get(file, {}).items() if joint in joints}

    def record(self, files: Sequence[str]) -> Record:
        """Return how some files are read, for the session and the page."""
        scales = {file: dict(self.scales.get(file, {})) for file in files}
        return {"effort": self.effort, "effort_delay": self.effort_delay, "scales": scales}


def with_lag(diagnosis: "Diagnosis", checks: Sequence["Check"]) -> list["Check"]:
    """Return the checks; a lag that the diagnosis found comes first, in place of their delay."""
    from lagrangian_ff.diagnosis.lag import late
    from lagrangian_ff.diagnosis.preflight.base import Check, Remedy

    if (lag := diagnosis.lag) is None:
        return list(checks)
    finding = late("every joint", lag.delay, lag.deviation)
    earlier = "effort" if lag.delay > 0 else "position"
    words = f"Read every {earlier} {1e3 * abs(lag.delay):.1f} ms earlier"
    # As many digits as the option shows, so that both do the same.
    remedy = Remedy(words, effort_delay=round(lag.delay, 4))
    advice = f"The model does not know it: learn again with {remedy.option}"
    others = [one for one in checks if (one.check, one.joint) != ("delay", None)]
    return [Check("lag", None, finding, True, advice, remedy=remedy), *others]


def told(check: "Check") -> Record:
    """Return what the page shows of a check, and the remedy behind its button."""
    remedy = check.remedy
    return {
        "finding": check.finding,
        "advice": check.advice,
        "serious": check.serious,
        "remedy": remedy and {
            "words": remedy.words,
            "scale": dict(remedy.effort_scale),
            "effort": remedy.effort,
            "delay": remedy.effort_delay,
        },
    }  # fmt: skip
