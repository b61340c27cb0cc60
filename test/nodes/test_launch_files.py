"""The launch files, run against stand-ins for `launch`, which no package index offers.

What is checked is ours: that they can be executed, that every argument is described, and that
the executables and parameter files they name exist. That ROS accepts them is not checked here.
"""

import ast
import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

FILES = ("demo.launch.py", "feedforward.launch.py", "monitor.launch.py", "record.launch.py")


class Given:
    """Stands for any launch class: keeps what it was made with."""

    def __init__(self, *positional: Any, **named: Any) -> None:
        self.positional = positional
        self.named = named

    def perform(self, context: dict[str, Any]) -> Any:
        name = self.positional[0]
        return context[name] if isinstance(name, str) else _performed(self, context["root"])


def run(path: Path, monkeypatch: pytest.MonkeyPatch, **arguments: str) -> tuple[Any, list[Any]]:
    """Return the launch description and the nodes it makes with these arguments."""
    for name, classes in {
        "launch": ("LaunchContext", "LaunchDescription"),
        "launch.actions": ("DeclareLaunchArgument", "OpaqueFunction"),
        "launch.substitutions": ("LaunchConfiguration", "PathJoinSubstitution"),
        "launch_ros": (),
        "launch_ros.actions": ("Node",),
        "launch_ros.substitutions": ("FindPackageShare",),
    }.items():
        module = ModuleType(name)
        for word in classes:
            setattr(module, word, type(word, (Given,), {}))
        monkeypatch.setitem(sys.modules, name, module)
    # It is to import the stand-ins of this test.
    monkeypatch.delitem(sys.modules, "lagrangian_ff.nodes.launching", raising=False)
    spec = importlib.util.spec_from_file_location(path.stem.replace(".", "_"), path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    description = module.generate_launch_description()
    entities = description.positional[0]
    context = {
        entity.positional[0]: _performed(entity.named["default_value"], path.parents[1])
        for entity in entities
        if type(entity).__name__ == "DeclareLaunchArgument"
    }
    make = next(e for e in entities if type(e).__name__ == "OpaqueFunction").named["function"]
    return entities, make({**context, **arguments, "root": path.parents[1]})


def _performed(value: Any, root: Path) -> str:
    """Return a default value as `launch` gives it; parameter files are those of the source."""
    return str(root.joinpath(*value.positional[0][1:])) if isinstance(value, Given) else value


def executables(root: Path) -> set[str]:
    """Return the console scripts that setup.py names."""
    texts = [
        node.value
        for node in ast.walk(ast.parse((root / "setup.py").read_text()))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    ]
    return {text.split("=")[0].strip() for text in texts if "lagrangian_ff.nodes." in text}


@pytest.mark.parametrize("name", FILES)
def test_arguments_are_described(root: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    entities, _ = run(root / "launch" / name, monkeypatch)
    arguments = {
        entity.positional[0]: entity.named["description"]
        for entity in entities
        if type(entity).__name__ == "DeclareLaunchArgument"
    }
    assert {"params_file", "namespace", "use_sim_time", "model_file"} <= set(arguments)
    assert all(len(text) > 10 for text in arguments.values())


@pytest.mark.parametrize("name", FILES)
def test_executables_and_parameter_files_exist(
    root: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    _, nodes = run(root / "launch" / name, monkeypatch, namespace="left")
    known = executables(root)
    assert known == {"identify", "feedforward", "monitor", "watchdog", "arm"}
    for node in nodes:
        assert node.named["executable"] in known
        assert node.named["namespace"] == "left"
        file = node.named["parameters"][0]
        assert Path(_performed(file, root)).is_file()


def test_arguments_reach_the_nodes(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = root / "launch" / "demo.launch.py"
    _, nodes = run(path, monkeypatch, model_file="m.npz", record="false", use_sim_time="true")
    assert [node.named["executable"] for node in nodes] == ["arm", "feedforward"]
    assert nodes[1].named["parameters"][1] == {"use_sim_time": True, "model_file": "m.npz"}
    assert nodes[0].named["parameters"][1]["publish_clock"] is True
    _, nodes = run(path, monkeypatch, use_sim_time="false")
    assert len(nodes) == 3
    assert nodes[0].named["parameters"][1]["publish_clock"] is False
    assert nodes[1].named["parameters"][1] == {"use_sim_time": False}
    assert "model_file" not in nodes[1].named["parameters"][1]
    _, nodes = run(root / "launch" / "record.launch.py", monkeypatch, joint_states="/arm/js")
    assert nodes[0].named["remappings"] == [("joint_states", "/arm/js")]


def test_a_home_folder_is_found_and_a_missing_file_of_parameters_refused(
    root: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    path = root / "launch" / "feedforward.launch.py"
    with pytest.raises(FileNotFoundError, match=r"mine\.yaml: set params_file"):
        run(path, monkeypatch, params_file="~/mine.yaml")
    (tmp_path / "mine.yaml").touch()
    _, (node, _) = run(path, monkeypatch, params_file="~/mine.yaml", model_file="~/m.npz")
    assert node.named["parameters"][0] == str(tmp_path / "mine.yaml")
    assert node.named["parameters"][1]["model_file"] == str(tmp_path / "m.npz")


def test_the_watchdog_stands_between_feedforward_and_controller(
    root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = root / "launch" / "feedforward.launch.py"
    _, (feedforward, watchdog) = run(path, monkeypatch, commands="/effort/commands")
    out = ("~/commands", "/effort/commands")
    assert out not in feedforward.named["remappings"]
    assert watchdog.named["remappings"] == [out]
    _, (alone,) = run(path, monkeypatch, commands="/effort/commands", watchdog="false")
    assert out in alone.named["remappings"]


def test_the_demo_takes_a_folder_and_hidden_physics(
    root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = root / "launch" / "demo.launch.py"
    _, (arm, _, recorder) = run(
        path,
        monkeypatch,
        model_file="m.npz",
        output_directory="bags",
        hidden="stribeck@joint_3:0.1 payload@joint_6:0.2",
    )
    assert arm.named["parameters"][1]["hidden"] == ["stribeck@joint_3:0.1", "payload@joint_6:0.2"]
    assert recorder.named["parameters"][1]["output_directory"] == "bags"
    assert recorder.named["parameters"][1]["model_file"] == "m.npz"
    _, (arm, _, _) = run(path, monkeypatch)
    assert "hidden" not in arm.named["parameters"][1]


def test_goals_go_on_to_a_controller_that_is_named(
    root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = root / "launch" / "feedforward.launch.py"
    _, (node, _) = run(path, monkeypatch, controller="arm_controller", respawn="true")
    assert node.named["parameters"][1]["controller"] == "arm_controller"
    assert node.named["respawn"] is True


@pytest.mark.parametrize("name", ["record", "feedforward", "monitor"])
def test_a_profile_goes_before_the_usual_parameters_and_after_ones_own(
    root: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, name: str
) -> None:
    path = root / "launch" / f"{name}.launch.py"
    profile = str(root / "config" / "arms" / "ur.yaml")
    node = run(path, monkeypatch, profile="ur")[1][0]
    assert node.named["parameters"][1] == profile
    mine = tmp_path / "mine.yaml"
    mine.touch()
    node = run(path, monkeypatch, profile="ur", params_file=str(mine))[1][0]
    assert node.named["parameters"][:2] == [profile, str(mine)]
    with pytest.raises(FileNotFoundError, match="no profile"):
        run(path, monkeypatch, profile="ru")
