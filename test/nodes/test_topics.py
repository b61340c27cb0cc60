"""Messages as bytes: what can be read of them without deserialising."""

import pytest

pytest.importorskip("rclpy")

from rclpy.serialization import serialize_message
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from lagrangian_ff.nodes.common.topics import count_points


@pytest.mark.parametrize("frame", ["", "base", "base_link"])
@pytest.mark.parametrize("names", [[], ["a"], ["elbow", "wrist_1", "wrist_22"]])
@pytest.mark.parametrize("count", [0, 1, 1234])
def test_points_are_counted(frame: str, names: list[str], count: int) -> None:
    message = JointTrajectory(joint_names=names)
    message.header.frame_id = frame
    message.points = [JointTrajectoryPoint(positions=[0.1] * len(names)) for _ in range(count)]
    assert count_points(serialize_message(message)) == count


@pytest.mark.parametrize("data", [b"", b"junk", b"\x00\x01\x00\x00" + b"\xff" * 40])
def test_what_is_no_trajectory_has_none(data: bytes) -> None:
    assert count_points(data) == 0
