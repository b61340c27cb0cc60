"""Judges from its answers whether a joint_trajectory_controller takes effort.

The rules are those of ros2_controllers on Jazzy: since 4.22.0 effort is added to the PID where
effort is the only command interface, and passed to the hardware where position and effort are
claimed; a trajectory with effort is rejected by a controller that claims no effort interface.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

TAKE_EFFORT = (("effort",), ("effort", "position"))
FORWARDING = ("JointGroupEffortController", "ForwardCommandController")
"""Controllers of these types pass torque on and control no position."""


@dataclass(frozen=True)
class Answers:
    """The answers about a controller; None where nobody answered.

    Attributes:
        state: "active", "inactive" or "unconfigured"; "" if the manager does not know it.
        claimed: the command interfaces it holds, such as "joint_1/effort".
        offered: the command interfaces that the hardware has.
        command_interfaces: its parameter, such as ("position", "effort").
        velocity_scale: its parameters gains.JOINT.ff_velocity_scale, by joint.
    """

    state: str | None = None
    claimed: tuple[str, ...] | None = None
    offered: tuple[str, ...] | None = None
    command_interfaces: tuple[str, ...] | None = None
    velocity_scale: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Loaded:
    """A controller as its manager lists it; the names are those of ControllerState."""

    name: str
    type: str
    state: str
    claimed: tuple[str, ...]


def open_loop(joints: Sequence[str], controllers: Sequence[Loaded]) -> str:
    """Return which controller passes torque on to a joint whose position nobody controls, or ""."""
    active = [one for one in controllers if one.state == "active"]
    for joint in joints:
        holding = [one for one in active if any(i.rpartition("/")[0] == joint for i in one.claimed)]
        passing = [
            one
            for one in holding
            if f"{joint}/effort" in one.claimed and one.type.endswith(FORWARDING)
        ]
        if passing and len(passing) == len(holding):
            return (
                f"{passing[0].name} passes torque on to {joint}, and nobody controls its position: "
                "use the parameter controller with joint_trajectory_controller, or set "
                "without_position_loop if another loop outside ros2_control does"
            )
    return ""


@dataclass(frozen=True)
class Verdict:
    """The judgement whether trajectories may carry effort.

    Attributes:
        effort: None if nobody answered, so that only trying shows it.
        said: why, and what to configure.
        good: whether there is nothing to put right.
    """

    effort: bool | None
    said: str
    good: bool


def judge(name: str, joints: Sequence[str], answers: Answers) -> Verdict:
    """Return whether the controller takes effort for these joints of the model."""
    interfaces = _interfaces(joints, answers)
    if answers.state == "":
        return Verdict(False, f"the controller manager has no {name}: load and activate it", False)
    if answers.state not in (None, "active"):
        return Verdict(False, f"{name} is {answers.state}: activate it", False)
    if interfaces is None:
        return Verdict(None, f"{name} did not say what it takes: effort is tried", True)
    kinds = tuple(sorted(interfaces))
    if kinds not in TAKE_EFFORT:
        has = " and ".join(kinds) or "nothing"
        return Verdict(
            False,
            f"goals pass without effort: {name} commands {has} and rejects effort; "
            + _advice(joints, answers),
            False,
        )
    if kinds == ("effort",) and (scaled := [j for j, v in answers.velocity_scale.items() if v]):
        return Verdict(
            True,
            f"effort is filled, but {name} adds torque over velocity itself: set "
            f"gains.{scaled[0]}.ff_velocity_scale to 0" + (" and so on" if scaled[1:] else ""),
            False,
        )
    way = "adds it to its PID" if kinds == ("effort",) else "passes it on beside the position"
    return Verdict(True, f"effort is filled: {name} {way}", True)


def _interfaces(joints: Sequence[str], answers: Answers) -> set[str] | None:
    """Return the kinds of interface that it commands for all of the joints."""
    if answers.claimed is None:
        kinds = answers.command_interfaces
        return None if kinds is None else set(kinds)
    by_joint = [
        {one.rpartition("/")[2] for one in answers.claimed if one.rpartition("/")[0] == joint}
        for joint in joints
    ]
    return set.intersection(*by_joint)


def _advice(joints: Sequence[str], answers: Answers) -> str:
    offered = answers.offered
    without = [] if offered is None else [j for j in joints if f"{j}/effort" not in offered]
    if without:
        return (
            f"the hardware offers no effort command interface for {', '.join(without)}: this robot "
            "takes no torque from outside (measure, diagnose and monitor it)"
        )
    return "set its command_interfaces to [position, effort], or to [effort] with gains for its PID"
