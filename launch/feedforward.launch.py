"""The feedforward for a robot, and the watchdog between it and the controller.

    ros2 launch lagrangian_ff feedforward.launch.py model_file:=model.npz \\
        controller:=joint_trajectory_controller
    ros2 launch lagrangian_ff feedforward.launch.py model_file:=model.npz commands:=/NAME/commands

The first takes goals of MoveIt and sends them on to the controller with effort. With the second,
`commands` is the topic of a driver that adds torque to its own loop. After `kill -9` of the
feedforward most drivers hold the last torque for ever; the watchdog fades it to zero.
"""

from collections.abc import Mapping

from launch import LaunchDescription
from launch_ros.actions import Node

from lagrangian_ff.nodes.launching import (
    PACKAGE,
    PROFILE,
    chosen,
    config,
    describe,
    parameter_files,
)

RESPAWN = 2.0  # s


def nodes(given: Mapping[str, str]) -> list[Node]:
    """Return the nodes for the values of the arguments."""
    time = {"use_sim_time": given["use_sim_time"].lower() == "true"}
    guarded = given["watchdog"].lower() == "true"
    common = {
        "package": PACKAGE,
        "namespace": given["namespace"],
        "output": "screen",
        "respawn": given["respawn"].lower() == "true",
        "respawn_delay": RESPAWN,
    }
    out = [("~/commands", given["commands"])] if given["commands"] else []
    feedforward = Node(
        executable="feedforward",
        name="feedforward",
        parameters=[*parameter_files(given), {**time, **chosen(given, "model_file", "controller")}],
        remappings=[("joint_states", given["joint_states"]), *([] if guarded else out)],
        **common,
    )
    if not guarded:
        return [feedforward]
    watchdog = Node(
        executable="watchdog",
        name="watchdog",
        parameters=[given["watchdog_params_file"], time],
        remappings=out,
        **common,
    )
    return [feedforward, watchdog]


def generate_launch_description() -> LaunchDescription:
    """Return the arguments and the nodes."""
    arguments = {
        "params_file": (config("feedforward.yaml"), "parameters of the feedforward"),
        "watchdog_params_file": (config("watchdog.yaml"), "parameters of the watchdog"),
        "profile": PROFILE,
        "namespace": ("", "namespace of the robot"),
        "use_sim_time": ("false", "whether the nodes take their time from /clock"),
        "joint_states": ("joint_states", "topic of the robot's joint states"),
        "controller": (
            "",
            "the joint_trajectory_controller that goals go on to with effort; empty = what "
            "params_file says",
        ),
        "respawn": ("false", "whether a node that ended without being asked is started again"),
        "commands": ("", "topic of the controller that takes torques; empty = watchdog/commands"),
        "watchdog": ("true", "whether the watchdog stands between feedforward and controller"),
        "model_file": ("", "identified model to load; empty = what params_file says"),
    }
    return describe(arguments, nodes)
