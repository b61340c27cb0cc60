"""The parts that the launch files share: arguments, and a node beside a robot."""

import os
from collections.abc import Callable, Mapping
from typing import Any

from launch import LaunchDescription  # type: ignore[attr-defined]  # hidden by our folder launch
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

PACKAGE = "lagrangian_ff"

Arguments = Mapping[str, tuple[object, str]]
"""Default value and description of each launch argument."""


def config(name: str) -> PathJoinSubstitution:
    """Return the path of a parameter file of the package."""
    return PathJoinSubstitution([FindPackageShare(PACKAGE), "config", name])


def describe(
    arguments: Arguments, nodes: Callable[[Mapping[str, str]], list[Node]]
) -> LaunchDescription:
    """Return a launch description; `nodes` makes the nodes for the values of the arguments.

    With the argument `profile` it goes before the usual file of parameters, and one that the user
    names goes before the profile: see `parameter_files`.
    """

    def make(context: Any) -> list[Node]:
        given = {name: LaunchConfiguration(name).perform(context) for name in arguments}
        given = {name: _file(name, value) for name, value in given.items()}
        if given.get("profile"):
            usual: Any = arguments["params_file"][0]
            profile, own = _profile(given["profile"], context), given["params_file"]
            ordered = [own, profile] if own == usual.perform(context) else [profile, own]
            given["params_file"] = os.pathsep.join(ordered)
        return nodes(given)

    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in arguments.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=make)])


def _profile(name: str, context: Any) -> str:
    """Return the file of a profile, which is named by its path or stands in config/arms.

    Raises:
        FileNotFoundError: there is no such file.
    """
    if name.endswith(".yaml"):
        path = os.path.expanduser(name)
    else:
        path = str(config(f"arms/{name}.yaml").perform(context))
    if not os.path.isfile(path):
        raise FileNotFoundError(
            f"there is no profile {path}; config/arms has those that come along"
        )
    return path


def _file(name: str, value: str) -> str:
    """Return a value; if it names a file or folder, with ~ replaced, which the shell leaves.

    Raises:
        FileNotFoundError: there is no such parameter file.
    """
    if not name.endswith(("file", "directory")):
        return value
    path = os.path.expanduser(value)
    if name.endswith("params_file") and not os.path.isfile(path):
        raise FileNotFoundError(f"there is no file {path}: set {name} to a file of parameters")
    return path


def parameter_files(given: Mapping[str, str]) -> list[str]:
    """Return the files of parameters; later ones go before earlier ones."""
    return given["params_file"].split(os.pathsep)


PROFILE = ("", "name of a file in config/arms, or a path: parameters for a driver; empty = none")


def chosen(given: Mapping[str, str], *names: str) -> dict[str, str]:
    """Return the arguments that were given; an empty one leaves what the parameter file says."""
    return {name: given[name] for name in names if given[name]}


def describe_beside_robot(
    executable: str, parameters_description: str, paths: Mapping[str, str], does: str
) -> LaunchDescription:
    """Return the launch description of one node that reads the joint states of a robot.

    Args:
        executable: name of the node and of its parameter file.
        parameters_description: of the argument params_file.
        paths: descriptions of the arguments that set a parameter of their name.
        does: what the node does with joint states, a verb.
    """

    def nodes(given: Mapping[str, str]) -> list[Node]:
        time = {"use_sim_time": given["use_sim_time"].lower() == "true"}
        return [
            Node(
                package=PACKAGE,
                executable=executable,
                name=executable,
                namespace=given["namespace"],
                output="screen",
                parameters=[*parameter_files(given), {**time, **chosen(given, *paths)}],
                remappings=[("joint_states", given["joint_states"])],
            )
        ]

    arguments: Arguments = {
        "params_file": (config(f"{executable}.yaml"), parameters_description),
        "profile": PROFILE,
        "namespace": ("", "namespace of the robot"),
        "use_sim_time": ("false", "whether the node takes its time from /clock"),
        "joint_states": ("joint_states", f"topic of the joint states to {does}"),
        **{name: ("", f"{text}; empty = what params_file says") for name, text in paths.items()},
    }
    return describe(arguments, nodes)
