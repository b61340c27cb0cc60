"""Watches whether a model still explains the torques of a robot that publishes joint states.

    ros2 launch lagrangian_ff monitor.launch.py model_file:=model.npz

Plot monitor/residual and monitor/predicted; /diagnostics says when the residual has grown.
"""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

PACKAGE = "lagrangian_ff"


def nodes(context: LaunchContext) -> list[Node]:
    """The monitor, for the values the arguments have now."""
    given = {
        name: LaunchConfiguration(name).perform(context)
        for name in ("params_file", "namespace", "use_sim_time", "model_file", "joint_states")
    }
    # An empty argument leaves what the parameter file says.
    model = {"model_file": given["model_file"]} if given["model_file"] else {}
    return [
        Node(
            package=PACKAGE,
            executable="monitor",
            name="monitor",
            namespace=given["namespace"],
            output="screen",
            parameters=[
                given["params_file"],
                {"use_sim_time": given["use_sim_time"].lower() == "true", **model},
            ],
            remappings=[("joint_states", given["joint_states"])],
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """The arguments and the node."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "params_file",
                default_value=PathJoinSubstitution(
                    [FindPackageShare(PACKAGE), "config", "monitor.yaml"]
                ),
                description="parameters of the monitor: rate, window, warn_ratio, ...",
            ),
            DeclareLaunchArgument(
                "namespace", default_value="", description="namespace of the robot"
            ),
            DeclareLaunchArgument(
                "use_sim_time",
                default_value="false",
                description="whether the node takes its time from /clock",
            ),
            DeclareLaunchArgument(
                "model_file",
                default_value="",
                description="identified model to watch; empty = what params_file says",
            ),
            DeclareLaunchArgument(
                "joint_states",
                default_value="joint_states",
                description="topic of the joint states to watch",
            ),
            OpaqueFunction(function=nodes),
        ]
    )
