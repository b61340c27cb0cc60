"""The simulated arm with the feedforward beside it, and the recorder.

    ros2 launch lagrangian_ff demo.launch.py model_file:=model.npz

Send the reference to feedforward/reference: it comes out of feedforward/joint_trajectory with
effort filled in and its start stamped, and goes from there to the arm. Time is the arm's own, on
/clock: on a busy machine it slows down. Further nodes take it with use_sim_time.
"""

from collections.abc import Mapping

from launch import LaunchDescription
from launch_ros.actions import Node

from lagrangian_ff.nodes.launching import PACKAGE, chosen, config, describe

WAIT = 1.0  # s


def nodes(given: Mapping[str, str]) -> list[Node]:
    """Return the nodes for the values of the arguments."""
    simulated = given["use_sim_time"].lower() == "true"
    time = {"use_sim_time": simulated}
    # The arm waits for the torque of every tick, so that none may be lost on the way.
    own_time = {"publish_clock": simulated, "wait_for_command": WAIT}
    hidden = {"hidden": given["hidden"].split()} if given["hidden"] else {}
    prefix = f"/{given['namespace']}" if given["namespace"] else ""
    reliable = {
        f"qos_overrides.{prefix}/{topic}.subscription.reliability": "reliable"
        for topic in ("joint_states", "feedforward/commands")
    }
    common = {"package": PACKAGE, "namespace": given["namespace"], "output": "screen"}
    arm = Node(
        executable="arm",
        name="arm",
        parameters=[config("arm.yaml"), {**own_time, **hidden}, reliable],
        remappings=[
            ("~/joint_trajectory", "feedforward/joint_trajectory"),
            ("~/commands", "feedforward/commands"),
        ],
        **common,
    )
    feedforward = Node(
        executable="feedforward",
        name="feedforward",
        parameters=[given["params_file"], {**time, **chosen(given, "model_file")}, reliable],
        **common,
    )
    if given["record"].lower() != "true":
        return [arm, feedforward]
    recorder = Node(
        executable="identify",
        name="identify",
        parameters=[
            config("identify.yaml"),
            {**time, **chosen(given, "model_file", "output_directory")},
            reliable,
        ],
        **common,
    )
    return [arm, feedforward, recorder]


def generate_launch_description() -> LaunchDescription:
    """Return the arguments and the nodes."""
    arguments = {
        "params_file": (config("feedforward.yaml"), "parameters of the feedforward"),
        "namespace": ("", "namespace of all nodes"),
        "use_sim_time": (
            "true",
            "whether time is the arm's own, on /clock, which waits for the feedforward; if not, "
            "all nodes use the system's clock",
        ),
        "model_file": ("", "identified model to load; empty = what params_file says"),
        "output_directory": ("", "where bags, models and findings are written; empty = here"),
        "hidden": (
            "",
            "physics to hide in the arm, for diagnose to find, such as stribeck@joint_3:0.1; "
            "several with spaces between",
        ),
        "record": ("true", "whether to start the recorder, too"),
    }
    return describe(arguments, nodes)
