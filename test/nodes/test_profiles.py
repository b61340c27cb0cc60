"""Profiles of arms: readable by every node, with their sources, and overridden by what is given."""

from pathlib import Path

import pytest

pytest.importorskip("rclpy")

import rclpy
from rclpy.context import Context
from rclpy.parameter import Parameter

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.node import Parameters
from lagrangian_ff.nodes.common.profiles import SOURCE, read_profile
from lagrangian_ff.nodes.streaming.plan import TERMS
from lagrangian_ff.recording.motion import EFFORTS

PROFILES = sorted(path.stem for path in (SOURCE / "config" / "arms").glob("*.yaml"))
KNOWN = {"joints", "effort", "rate", *(f"terms.{term}" for term in TERMS)}


@pytest.mark.parametrize("name", PROFILES)
def test_every_profile_is_of_known_parameters_and_says_what_it_rests_on(name: str) -> None:
    found = read_profile(name)
    assert set(found) <= KNOWN
    assert found["effort"] in EFFORTS
    assert len(set(found.get("joints", []))) == len(found.get("joints", []))
    text = (SOURCE / "config" / "arms" / f"{name}.yaml").read_text()
    for word in (
        "# Effort in joint_states:",
        "# Torque commands:",
        "# Known not to work:",
        "https://",
    ):
        assert word in text


def test_all_of_the_arms_that_are_named_have_one() -> None:
    arms = {"ur", "franka", "kuka_lbr", "kinova_gen3", "xarm", "dynamixel"}
    assert arms | {"gz_ros2_control", "mujoco_ros2_control"} <= set(PROFILES)


def test_a_profile_goes_before_defaults_and_after_what_is_given(
    ros_environment: dict[str, str],
) -> None:
    context = Context()
    rclpy.init(context=context)
    given = [Parameter("profile", value="franka"), Parameter("terms.friction", value=True)]
    node = rclpy.create_node("arm_of_a_profile", context=context, parameter_overrides=given)
    try:
        parameters = Parameters(node, profiles=True)
        for term in TERMS:
            parameters.declare(f"terms.{term}", True, "whether it is sent")
        parameters.declare("rate", 500.0, "Hz", low=1.0, high=2000.0)
        assert {term: parameters.value(f"terms.{term}") for term in TERMS} == {
            "gravity": False,
            "inertia": True,
            "coriolis": True,
            "friction": True,
        }
        assert parameters.value("rate") == 1000.0
    finally:
        node.destroy_node()
        context.try_shutdown()


def test_what_is_no_profile_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"no profile ru .*franka.*ur"):
        read_profile("ru")
    for text in ("joints: [a]", "[1, 2", "3"):
        (tmp_path / "mine.yaml").write_text(text)
        with pytest.raises(UserError, match="no file of parameters"):
            read_profile(str(tmp_path / "mine.yaml"))
    (tmp_path / "mine.yaml").write_text("/**:\n  ros__parameters: {effort_scale: {a: 2.5}}")
    assert read_profile(str(tmp_path / "mine.yaml")) == {"effort_scale.a": 2.5}
