"""Watches whether a model still explains the torques of a robot that publishes joint states.

    ros2 launch lagrangian_ff monitor.launch.py model_file:=model.npz

Plot monitor/residual and monitor/predicted; /diagnostics says when the residual has grown.
"""

from launch import LaunchDescription

from lagrangian_ff.nodes.launching import describe_beside_robot


def generate_launch_description() -> LaunchDescription:
    """Return the arguments and the node."""
    return describe_beside_robot(
        "monitor",
        "parameters of the monitor: rate, window, warn_ratio, ...",
        {"model_file": "identified model to watch"},
        does="watch",
    )
