"""The rooms of the house: who may import whom, what only some may import, how long a file is."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "lagrangian_ff"

LOW = {"recording"}
MODEL = {"kernels", "effects", *LOW}
IDENTIFIED = {"identification", *MODEL}
UNDERSTOOD = {"diagnosis", *IDENTIFIED}
# A room may import those on the right, itself, and what is for all.
ARROWS: dict[str, set[str]] = {
    "recording": {"loops"},  # which counts the ticks of a clock
    "loops": set(),
    "kernels": {"loops", *LOW},
    "effects": {
        "kernels",
        "loops",
        *LOW,
    },  # an effect is a function of the states that kernels compare
    "identification": MODEL,
    "diagnosis": IDENTIFIED,
    # Not the effects: the plant's physics must not share code with what is to find it.
    "arm": {"loops", *LOW},
    "export": {"loops", *IDENTIFIED},  # whose C code goes into what is exported
    "investigation": UNDERSTOOD,
    "report": {"investigation", *UNDERSTOOD},
    "nodes": {"arm", "investigation", "report", *UNDERSTOOD},
    "studies": {"arm", "investigation", "report", *UNDERSTOOD},
    "workbench": {"arm", "investigation", "report", *UNDERSTOOD},
    "demo": {"arm", "nodes", "report", *UNDERSTOOD},
    "cli": {
        "arm",
        "demo",
        "export",
        "investigation",
        "nodes",
        "report",
        "studies",
        "workbench",
        *UNDERSTOOD,
    },
}
FOR_ALL = {
    "arrays", "budget", "errors", "files", "lazy", "numbers", "progress", "record_json",
    "sampling", "words", "worker", "__version__", "",
}  # fmt: skip
ROS = {"rclpy", "std_srvs", "rcl_interfaces", "builtin_interfaces", "ament_index_python", "launch"}


def sources(*folders: str) -> list[Path]:
    """Return the Python files below the folders."""
    return sorted(file for folder in folders for file in (ROOT / folder).rglob("*.py"))


@cache
def imports(file: Path) -> list[tuple[int, str]]:
    """Return the line and the dotted name of every import in a file, the relative ones too."""
    return list(imports_of(file.read_text(), list(file.relative_to(ROOT).parts[:-1])))


def imports_of(text: str, package: list[str]) -> Iterator[tuple[int, str]]:
    """Yield the imports in the text of a module that lies in the package."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            start = package[: len(package) - node.level + 1] if node.level else []
            module = ".".join([*start, *filter(None, [node.module])])
            # `from lagrangian_ff import recording` names a module behind the word import.
            names = [
                alias.name
                for alias in node.names
                if module == PACKAGE.name or is_module(f"{module}.{alias.name}")
            ]
            yield from ((node.lineno, f"{module}.{name}".rstrip(".")) for name in names or [""])


def is_module(dotted: str) -> bool:
    """Return whether a dotted name is that of a file or folder of the package."""
    path = ROOT.joinpath(*dotted.split("."))
    return dotted.startswith(PACKAGE.name) and (path.is_dir() or path.with_suffix(".py").exists())


def module_name(file: Path) -> str:
    """Return the dotted name of a file; that of its folder for `__init__.py`."""
    return ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def room(dotted: str) -> str:
    """Return the room that a dotted name of the package lies in, empty for the package itself."""
    return [*dotted.split("."), ""][1]


def is_ros(name: str) -> bool:
    """Return whether a top-level module comes with ROS."""
    return name in ROS or name.endswith("_msgs") or name.startswith("rosidl")


def test_every_room_is_known() -> None:
    rooms = {file.relative_to(PACKAGE).parts[0] for file in sources(PACKAGE.name)}
    folders = {name for name in rooms if not name.endswith(".py")}
    assert folders <= set(ARROWS), "a room without arrows: add it to ARROWS and to the docs"


@pytest.mark.parametrize("name", ARROWS)
def test_arrows_point_one_way(name: str) -> None:
    allowed = ARROWS[name] | FOR_ALL | {name}
    wrong = [
        f"{file.relative_to(ROOT)}:{line} imports {imported}"
        for file in sources(f"{PACKAGE.name}/{name}")
        for line, imported in imports(file)
        if imported.split(".")[0] == PACKAGE.name and room(imported) not in allowed
    ]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("name", ARROWS)
def test_no_circle_of_imports_inside_a_room(name: str) -> None:
    """Imports inside functions and those for type checkers count, too."""
    files = {module_name(file): file for file in sources(f"{PACKAGE.name}/{name}")}
    graph = {
        module: {imported for _, imported in imports(file) if imported in files}
        for module, file in files.items()
    }
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" imports ".join(reversed(error.args[1])))


def test_what_is_for_all_rests_on_no_room() -> None:
    for file in PACKAGE.glob("*.py"):
        rooms = {room(name) for _, name in imports(file) if name.split(".")[0] == PACKAGE.name}
        assert rooms <= FOR_ALL, f"{file.name} imports {rooms}"


def test_only_the_arm_knows_pybullet() -> None:
    users = {
        file.relative_to(PACKAGE).parts[0]
        for file in sources(PACKAGE.name)
        for _, name in imports(file)
        if name.split(".")[0].startswith("pybullet")
    }
    assert users <= {"arm"}


def test_only_nodes_and_demo_know_ros() -> None:
    wrong = [
        f"{file.relative_to(ROOT)}:{line} imports {name}"
        for file in sources(PACKAGE.name)
        for line, name in imports(file)
        if is_ros(name.split(".")[0])
        and file.relative_to(PACKAGE).parts[0] not in {"nodes", "demo"}
    ]
    assert not wrong, "\n".join(wrong)


def test_the_reader_of_imports_sees_every_form() -> None:
    text = """
import a.b
from ..recording import x
from . import y
from lagrangian_ff import nodes
def f():
    from rclpy.node import Node
"""
    names = [name for _, name in imports_of(text, ["lagrangian_ff", "arm"])]
    assert names == [
        "a.b",
        "lagrangian_ff.recording",
        "lagrangian_ff.arm",
        "lagrangian_ff.nodes",
        "rclpy.node",
    ]


def test_no_file_is_long() -> None:
    folders = ("lagrangian_ff", "test", "launch", "benchmark", "tools")
    lengths = {file: len(file.read_text().splitlines()) for file in sources(*folders)}
    long = {str(file.relative_to(ROOT)): n for file, n in lengths.items() if n > 400}
    assert not long
