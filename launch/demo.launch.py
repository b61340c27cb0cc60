"""The simulated arm with the feedforward beside it, and the recorder.

    ros2 launch lagrangian_ff demo.launch.py model_file:=model.npz

Send the reference to feedforward/reference: it comes out of feedforward/joint_trajectory with
effort filled in and its start stamped, and goes from there to the arm. Time is the arm's own, on
/clock: where the machine is busy it goes more slowly. Further nodes take it with use_sim_time.
"""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

PACKAGE = "lagrangian_ff"
WAIT = 1.0  # s


def config(name: str) -> PathJoinSubstitution:
    """A parameter file of the package."""
    return PathJoinSubstitution([FindPackageShare(PACKAGE), "config", name])


def nodes(context: LaunchContext) -> list[Node]:
    """The nodes, for the values the arguments have now."""
    given = {
        name: LaunchConfiguration(name).perform(context)
        for name in ("params_file", "namespace", "use_sim_time", "model_file", "record")
    }
    simulated = given["use_sim_time"].lower() == "true"
    time = {"use_sim_time": simulated}
    # The arm waits for the torque of every tick, so that none may be lost on the way.
    own_time = {"publish_clock": simulated, "wait_for_command": WAIT}
    prefix = f"/{given['namespace']}" if given["namespace"] else ""
    reliable = {
        f"qos_overrides.{prefix}/{topic}.subscription.reliability": "reliable"
        for topic in ("joint_states", "feedforward/commands")
    }
    common = {"package": PACKAGE, "namespace": given["namespace"], "output": "screen"}
    # An empty argument leaves what the parameter file says.
    model = {"model_file": given["model_file"]} if given["model_file"] else {}
    arm = Node(
        executable="arm",
        name="arm",
        parameters=[config("arm.yaml"), own_time, reliable],
        remappings=[
            ("~/joint_trajectory", "feedforward/joint_trajectory"),
            ("~/commands", "feedforward/commands"),
        ],
        **common,
    )
    feedforward = Node(
        executable="feedforward",
        name="feedforward",
        parameters=[given["params_file"], {**time, **model}, reliable],
        **common,
    )
    if given["record"].lower() != "true":
        return [arm, feedforward]
    recorder = Node(
        executable="identify",
        name="identify",
        parameters=[config("identify.yaml"), time, reliable],
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
                default_value="true",
                description="whether time is the arm's own, on /clock, which waits for the "
                "feedforward; if not, all go by the system's clock",
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
