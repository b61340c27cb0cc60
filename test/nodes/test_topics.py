"""Messages: what their bytes say without deserialising, and trajectories with more points."""

import numpy as np
import pytest

pytest.importorskip("rclpy")

from builtin_interfaces.msg import Duration
from controller_rules import Motion
from rclpy.serialization import serialize_message
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from lagrangian_ff.nodes.common.topics import count_points, points, resampled
from lagrangian_ff.nodes.streaming.reference import read_path


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


@pytest.mark.parametrize(("kinds", "degree"), [("", 1), ("v", 3), ("va", 5)])
def test_a_path_is_that_of_the_controller_also_with_more_points(kinds: str, degree: int) -> None:
    random = np.random.default_rng(degree)
    message = JointTrajectory(joint_names=["a", "b"])
    for number in range(5):
        point = JointTrajectoryPoint(positions=random.uniform(-1.0, 1.0, 2).tolist())
        if "v" in kinds:
            point.velocities = random.uniform(-1.0, 1.0, 2).tolist()
        if "a" in kinds:
            point.accelerations = random.uniform(-1.0, 1.0, 2).tolist()
        point.time_from_start = Duration(sec=number, nanosec=300_000_000 * (number % 2))
        message.points.append(point)
    path = read_path(points(message), ["a", "b"])
    assert path.degree == degree
    time = np.sort(np.append(random.uniform(0.0, path.duration, 40), path.time))
    more = resampled(message, path, time, ("b",), np.linspace(0.0, 1.0, 45)[:, None])
    given, filled = (Motion(one, ["a", "b"], np.zeros(2)) for one in (message, more))
    # A point of the message has the velocity of the interval after it: between points all agree.
    for at in random.uniform(0.0, path.duration, 200):
        q, qd, _ = path.sample(np.array(at))
        np.testing.assert_allclose(q, given.at(at)[0], atol=1e-7)
        np.testing.assert_allclose(qd, given.at(at)[1], atol=1e-6)
        np.testing.assert_allclose(filled.at(at)[0], given.at(at)[0], atol=1e-7)
        np.testing.assert_allclose(filled.at(at)[1], given.at(at)[1], atol=1e-5)
    assert filled.at(0.5 * (time[7] + time[8]))[2] == pytest.approx([0.0, 7.5 / 44.0])
