"""The feedforward for a robot, and the watchdog between it and the controller.

    ros2 launch lagrangian_ff feedforward.launch.py model_file:=model.npz commands:=/NAME/commands

`commands` is the topic of the controller that takes torques, such as JointGroupEffortController.
After `kill -9` of the feedforward such a controller holds the last torque for ever; the watchdog
fades it to zero.
"""

from collections.abc import Mapping

from launch import LaunchDescription
from launch_ros.actions import Node

from lagrangian_ff.nodes.launching import PACKAGE, chosen, config, describe


def nodes(given: Mapping[str, str]) -> list[Node]:
    """Return the nodes for the values of the arguments."""
    time = {"use_sim_time": given["use_sim_time"].lower() == "true"}
    guarded = given["watchdog"].lower() == "true"
    common = {"package": PACKAGE, "namespace": given["namespace"], "output": "screen"}
    out = [("~/commands", given["commands"])] if given["commands"] else []
    feedforward = Node(
        executable="feedforward",
        name="feedforward",
        parameters=[given["params_file"], {**time, **chosen(given, "model_file")}],
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
        "namespace": ("", "namespace of the robot"),
        "use_sim_time": ("false", "whether the nodes take their time from /clock"),
        "joint_states": ("joint_states", "topic of the robot's joint states"),
        "commands": ("", "topic of the controller that takes torques; empty = watchdog/commands"),
        "watchdog": ("true", "whether the watchdog stands between feedforward and controller"),
        "model_file": ("", "identified model to load; empty = what params_file says"),
    }
    return describe(arguments, nodes)
