"""The simulated arm with the feedforward beside it, and the recorder.

    ros2 launch lagrangian_ff demo.launch.py model_file:=model.npz

Send the reference to feedforward/reference: it comes out of feedforward/joint_trajectory with
effort filled in and its start stamped, and goes from there to the arm.
"""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

PACKAGE = "lagrangian_ff"


def config(name: str) -> PathJoinSubstitution:
    """A parameter file of the package."""
    return PathJoinSubstitution([FindPackageShare(PACKAGE), "config", name])


def nodes(context: LaunchContext) -> list[Node]:
    """The nodes, for the values the arguments have now."""
    given = {
        name: LaunchConfiguration(name).perform(context)
        for name in ("params_file", "namespace", "use_sim_time", "model_file", "record")
    }
    time = {"use_sim_time": given["use_sim_time"].lower() == "true"}
    common = {"package": PACKAGE, "namespace": given["namespace"], "output": "screen"}
    # An empty argument leaves what the parameter file says.
    model = {"model_file": given["model_file"]} if given["model_file"] else {}
    arm = Node(
        executable="arm",
        name="arm",
        parameters=[config("arm.yaml"), time],
        remappings=[
            ("~/joint_trajectory", "feedforward/joint_trajectory"),
            ("~/commands", "feedforward/commands"),
        ],
        **common,
    )
    feedforward = Node(
        executable="feedforward",
        name="feedforward",
        parameters=[given["params_file"], {**time, **model}],
        **common,
    )
    if given["record"].lower() != "true":
        return [arm, feedforward]
    recorder = Node(
        executable="identify",
        name="identify",
        parameters=[config("identify.yaml"), time],
        **common,
    )
    return [arm, feedforward, recorder]


def generate_launch_description() -> LaunchDescription:
    """The arguments and the nodes."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "params_file",
                default_value=config("feedforward.yaml"),
                description="parameters of the feedforward",
            ),
            DeclareLaunchArgument(
                "namespace", default_value="", description="namespace of all nodes"
            ),
            DeclareLaunchArgument(
                "use_sim_time",
                default_value="false",
                description="whether the nodes take their time from /clock; the arm does not "
                "publish one and is paced by the wall clock",
            ),
            DeclareLaunchArgument(
                "model_file",
                default_value="",
                description="identified model to load; empty = what params_file says",
            ),
            DeclareLaunchArgument(
                "record", default_value="true", description="whether to start the recorder, too"
            ),
            OpaqueFunction(function=nodes),
        ]
    )
