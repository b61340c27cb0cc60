"""The order of the joints from base to tool: by names, by a description, or by the torques."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("pybullet")

from lagrangian_ff.arm import exciting_trajectory, simulate
from lagrangian_ff.identification import Settings, identify, joint_order
from lagrangian_ff.identification.ordering import numbered
from lagrangian_ff.kernels.rigid import read_urdf
from lagrangian_ff.recording import Motion, condition

NAMES = ("pan", "lift", "elbow", "first", "second", "third")
ALPHABETICAL = tuple(sorted(NAMES))


@pytest.fixture(scope="module")
def motion() -> Motion:
    recording = simulate(exciting_trajectory(5, seed=0, duration=20.0)).recording
    return replace(condition(recording), joints=NAMES)


@pytest.mark.parametrize(
    ("names", "known"),
    [
        (["joint_1", "joint_2", "joint_3"], True),
        (["left_arm_j0", "left_arm_j1"], True),
        (["panda_joint9_x", "panda_joint10_x"], True),
        (["joint_2", "joint_1", "joint_3"], False),
        (["joint_1", "axis_2"], False),
        (["wrist_1", "elbow"], False),
        (["joint_1", "joint_1"], False),
    ],
)
def test_names_that_count_are_in_order(names: list[str], known: bool) -> None:
    assert numbered(names) is known


def test_the_torques_put_a_sorted_arm_in_order(motion: Motion) -> None:
    """Wrists whose axes meet may change places; what carries the others may not."""
    moved = motion.select(ALPHABETICAL)
    found = joint_order([moved], "auto+fri")
    assert found.joints[:3] == NAMES[:3]
    assert found.nats > 50.0
    assert "pan, lift, elbow" in found.words(ALPHABETICAL)
    settings = Settings(samples=200)
    wrong = identify(moved, settings).model.identified.score.total
    right = identify(moved.select(found.joints), settings).model.identified.score.total
    assert right < 0.6 * wrong


def test_a_right_order_is_kept(motion: Motion) -> None:
    found = joint_order([motion], "auto+fri")
    assert found.joints[:3] == NAMES[:3]
    assert joint_order([motion.select(ALPHABETICAL)], "vrbfs+fri").joints == ALPHABETICAL


def test_a_description_says_the_order(motion: Motion) -> None:
    from lagrangian_ff.arm.description import URDF

    given = tuple(f"joint_{number}" for number in (3, 1, 2, 6, 5, 4))
    moved = replace(motion, joints=given)
    found = joint_order([moved], "auto+fri", read_urdf(URDF))
    assert found.joints == tuple(f"joint_{number}" for number in range(1, 7))
    assert "by the description" in found.words(given)
    np.testing.assert_array_equal(moved.select(found.joints).q[:, 2], moved.q[:, 0])
