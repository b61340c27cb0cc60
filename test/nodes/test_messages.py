"""Messages made from arrays."""

import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from lagrangian_ff.nodes.common.messages import JointStateMaker, nanoseconds


@pytest.mark.parametrize("joints", [("a",), ("base", "elbow"), ("j_1", "j_2", "j_3", "j_4", "j_5")])
def test_a_joint_state_is_read_as_it_was_filled_in(joints: tuple[str, ...]) -> None:
    maker = JointStateMaker(joints)
    random = np.random.default_rng(0)
    for at in (5, 1_795_385_495_581_352_713):
        position, velocity, effort = random.normal(size=(3, len(joints)))
        velocity[0] = np.nan
        message = deserialize_message(maker.fill(at, position, velocity, effort), JointState)
        assert nanoseconds(message.header.stamp) == at
        assert tuple(message.name) == joints
        np.testing.assert_array_equal(message.position, position)
        np.testing.assert_array_equal(message.velocity, velocity)
        np.testing.assert_array_equal(message.effort, effort)
