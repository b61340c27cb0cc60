"""Whether a controller takes effort, by what it answered."""

import pytest

from lagrangian_ff.nodes.streaming.controller import Answers, Loaded, judge, open_loop

JOINTS = ("a", "b")
BOTH = ("a/effort", "b/effort", "a/position", "b/position")


@pytest.mark.parametrize(
    ("answers", "effort", "said"),
    [
        (Answers(), None, "effort is tried"),
        (Answers(command_interfaces=("effort",)), True, "adds it to its PID"),
        (Answers(command_interfaces=("position", "effort")), True, "beside the position"),
        (Answers(command_interfaces=("position",)), False, "[position, effort]"),
        (Answers(command_interfaces=("velocity", "effort")), False, "effort and velocity"),
        (Answers("active", BOTH[:2]), True, "adds it to its PID"),
        (Answers("active", BOTH), True, "beside the position"),
        # What it holds counts, not what it was told to hold.
        (Answers("active", BOTH[2:], None, ("effort",)), False, "commands position"),
        (Answers("active", BOTH[:1]), False, "commands nothing"),
        (Answers("inactive", BOTH), False, "is inactive: activate it"),
        (Answers(""), False, "has no jtc"),
        (Answers("active", BOTH[2:], BOTH[2:]), False, "no effort command interface for a, b"),
    ],
)
def test_effort_is_filled_only_where_it_is_taken(
    answers: Answers, effort: bool | None, said: str
) -> None:
    found = judge("jtc", JOINTS, answers)
    assert found.effort is effort
    assert said in found.said
    assert found.good == (effort is not False)


def test_torque_over_velocity_of_the_controller_is_named() -> None:
    answers = Answers("active", BOTH[:2], velocity_scale={"a": 0.0, "b": 0.5})
    found = judge("jtc", JOINTS, answers)
    assert found.effort
    assert not found.good
    assert "gains.b.ff_velocity_scale to 0" in found.said


GROUP = Loaded("group", "effort_controllers/JointGroupEffortController", "active", ("a/effort",))
TRAJECTORY = "joint_trajectory_controller/JointTrajectoryController"


@pytest.mark.parametrize(
    ("controllers", "alone"),
    [
        ([], False),
        ([GROUP], True),
        ([Loaded("f", "forward_command_controller/ForwardCommandController", "active",
                 ("b/effort",))], True),
        ([Loaded("f", "forward_command_controller/ForwardCommandController", "active",
                 ("b/position",))], False),
        ([Loaded("group", GROUP.type, "inactive", ())], False),
        ([Loaded("jtc", TRAJECTORY, "active", ("a/effort", "b/effort"))], False),
        ([GROUP, Loaded("jtc", TRAJECTORY, "active", ("a/position",))], False),
        ([Loaded("group", GROUP.type, "active", ("elsewhere/effort",))], False),
    ],
)  # fmt: skip
def test_torque_alone_is_noticed(controllers: list[Loaded], alone: bool) -> None:
    assert ("nobody controls its position" in open_loop(JOINTS, controllers)) is alone
