"""The recorder beside a real robot that publishes joint states.

    ros2 launch lagrangian_ff record.launch.py joint_states:=/joint_states

Then call identify/start, move the robot, call identify/stop, identify/identify, identify/save.
Later, with model_file: start and stop once more, then identify/compare, identify/diagnose and
identify/add.
"""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

PACKAGE = "lagrangian_ff"


def nodes(context: LaunchContext) -> list[Node]:
    """The recorder, for the values the arguments have now."""
    given = {
        name: LaunchConfiguration(name).perform(context)
        for name in (
            "params_file", "namespace", "use_sim_time", "model_file", "joint_states",
            "output_directory",
        )
    }  # fmt: skip
    # An empty argument leaves what the parameter file says.
    paths = {name: given[name] for name in ("model_file", "output_directory") if given[name]}
    return [
        Node(
            package=PACKAGE,
            executable="identify",
            name="identify",
            namespace=given["namespace"],
            output="screen",
            parameters=[
                given["params_file"],
                {"use_sim_time": given["use_sim_time"].lower() == "true", **paths},
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
                    [FindPackageShare(PACKAGE), "config", "identify.yaml"]
                ),
                description="parameters of the recorder: joints, model, effort_scale, ...",
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
                description="the model to compare and diagnose, and where identify/save puts the "
                "last one; empty = what params_file says",
            ),
            DeclareLaunchArgument(
                "joint_states",
                default_value="joint_states",
                description="topic of the joint states to record",
            ),
            DeclareLaunchArgument(
                "output_directory",
                default_value="",
                description="where bags, models and findings are written; empty = what "
                "params_file says",
            ),
            OpaqueFunction(function=nodes),
        ]
    )
