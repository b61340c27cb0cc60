"""What the package says of itself, in four files and two packaging worlds, agrees."""

from __future__ import annotations

import ast
import itertools
import os
import re
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import pytest

import lagrangian_ff

ROOT = Path(__file__).resolve().parents[2]
MANIFEST = ElementTree.parse(ROOT / "package.xml").getroot()

# Where the name on the package index and the rosdep key differ.
ROSDEP = {"pyyaml": "python3-yaml"}
OPTIONAL = ("arm", "bags", "threads", "urdf", "onnx", "cluster")
DISTRIBUTION = {
    "xdist": "pytest-xdist",
    "sklearn": "scikit-learn",
    "pinocchio": "pin",
    "pybullet_data": "pybullet",
    "ruamel": "ruamel.yaml",
    "yaml": "pyyaml",
}


def setup_of(*names: str) -> dict[str, object]:
    """Return what setup.py assigns to the names, without running it."""
    tree = ast.parse((ROOT / "setup.py").read_text())
    values = {
        node.targets[0].id: ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign)
        and isinstance(node.targets[0], ast.Name)
        and node.targets[0].id in names
    }
    call = next(
        n.value for n in tree.body if isinstance(n, ast.Expr) and isinstance(n.value, ast.Call)
    )
    values |= {
        keyword.arg: ast.literal_eval(keyword.value)
        for keyword in call.keywords
        if keyword.arg in names
    }
    return values


def runtime() -> set[str]:
    """Return the names of the libraries that setup.py requires."""
    requirements = setup_of("RUNTIME")["RUNTIME"]
    assert isinstance(requirements, list)
    return {str(requirement).split()[0] for requirement in requirements}


def optional() -> set[str]:
    """Return the names of the libraries that are used where they are installed."""
    extras = setup_of("EXTRAS")["EXTRAS"]
    assert isinstance(extras, dict)
    return {str(requirement).split()[0] for extra in OPTIONAL for requirement in extras[extra]}


def depends(kind: str) -> set[str]:
    """Return the keys that package.xml lists under one kind of dependency."""
    return {str(element.text) for element in MANIFEST.iter(kind)}


def tracked() -> list[Path]:
    """Return the files under version control."""
    if not (ROOT / ".git").exists() or not shutil.which("git"):
        pytest.skip("not a git clone")
    # -c safe.directory: the clone may belong to another user than the one who tests it.
    command = ["git", "-c", f"safe.directory={ROOT}", "-C", str(ROOT), "ls-files", "-z"]
    names = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return [ROOT / name for name in names.split("\0") if name and (ROOT / name).is_file()]


def imported(*folders: str) -> set[str]:
    """Return the top-level modules that files of the folders import, the standard library's not."""
    files = (file for folder in folders for file in (ROOT / folder).rglob("*.py"))
    modules = {module for file in files for module in imported_by(file)}
    return modules - set(sys.stdlib_module_names) - {"lagrangian_ff"}


@cache
def imported_by(file: Path) -> set[str]:
    """Return the top-level modules that a file imports."""
    modules: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            modules |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            modules.add(node.module.split(".")[0])
    return modules


def is_ros(module: str) -> bool:
    """Tell whether a module comes with ROS and so stands in package.xml under its own name."""
    ros = {"rclpy", "std_srvs", "rcl_interfaces", "builtin_interfaces", "ament_index_python"}
    ros |= {"rosbag2_py"}
    return module in ros or module.endswith("_msgs") or module.startswith(("launch", "rosidl"))


def test_versions_agree() -> None:
    """`__version__` is the one place; ROS reads a copy of it in package.xml."""
    told = subprocess.run(
        [sys.executable, "setup.py", "--version"],
        cwd=ROOT,
        capture_output=True,
        check=True,
        text=True,
    )
    assert told.stdout.split()[-1] == lagrangian_ff.__version__
    assert MANIFEST.findtext("version") == lagrangian_ff.__version__


def test_changelog_has_the_form_that_releases_are_made_from() -> None:
    title, *lines = (ROOT / "CHANGELOG.rst").read_text().splitlines()[1:]
    assert title == "Changelog for package lagrangian_ff"
    headings = [line for line, under in itertools.pairwise(lines) if set(under) == {"-"}]
    released = r"\d+\.\d+\.\d+ \(\d{4}-\d{2}-\d{2}\)"
    assert all(re.fullmatch(f"Forthcoming|{released}", heading) for heading in headings), headings
    assert headings[0].split()[0] in {"Forthcoming", MANIFEST.findtext("version")}
    assert "Forthcoming" not in headings[1:]


def test_manifest_is_valid() -> None:
    package = pytest.importorskip("catkin_pkg.package")
    warnings: list[str] = []
    parsed = package.parse_package(str(ROOT / "package.xml"), warnings=warnings)
    parsed.validate(warnings=warnings)
    assert warnings == []
    assert parsed.name == "lagrangian_ff"
    assert parsed.get_build_type() == "ament_python"
    assert parsed.package_format == 3


def test_manifest_lists_the_ros_packages_that_are_imported() -> None:
    used = {module for module in imported("lagrangian_ff", "launch") if is_ros(module)}
    assert used <= depends("exec_depend")


def test_setup_and_manifest_list_the_libraries_that_are_imported() -> None:
    used = {
        DISTRIBUTION.get(module, module)
        for module in imported("lagrangian_ff")
        if not is_ros(module)
    }
    assert used == runtime() | optional()
    keys = {ROSDEP.get(name, f"python3-{name}") for name in runtime()}
    assert keys <= depends("exec_depend")


def test_no_dependency_comes_from_pip_alone() -> None:
    assert not [key for element in MANIFEST if (key := str(element.text)).endswith("-pip")]


def test_setup_lists_the_libraries_that_tests_import() -> None:
    extras = setup_of("EXTRAS")["EXTRAS"]
    assert isinstance(extras, dict)
    wanted = [
        requirement
        for name in ("test", "docs", "benchmark", "fuzz")
        for requirement in extras[name]
    ]
    known = runtime() | optional() | {str(requirement).split()[0] for requirement in wanted}
    siblings = {file.stem for part in ("test", "benchmark") for file in (ROOT / part).rglob("*.py")}
    siblings |= {path.stem for path in (ROOT / "tools").iterdir()}
    used = (
        imported("test", "benchmark", "tools") - siblings - {"catkin_pkg"}
    )  # colcon-ros brings it
    assert {DISTRIBUTION.get(name, name) for name in used if not is_ros(name)} <= known


def test_oldest_versions_are_those_that_setup_allows() -> None:
    requirements = setup_of("RUNTIME", "EXTRAS")
    assert isinstance(requirements["RUNTIME"], list)
    assert isinstance(requirements["EXTRAS"], dict)
    ranges = dict(
        str(requirement).split(None, 1)
        for requirement in [
            *requirements["RUNTIME"],
            *itertools.chain(*(requirements["EXTRAS"][extra] for extra in (*OPTIONAL, "test"))),
        ]
    )
    constraints = (ROOT / "constraints-ubuntu-24.04.txt").read_text()
    line = re.compile(r'^(\S+) ==([\d.]+)(?:; python_version < "3.12")?$', re.MULTILINE)
    oldest = dict(line.findall(constraints))
    assert set(oldest) >= runtime() | optional()
    for name, version in oldest.items():
        low = re.match(r">=([\d.]+), <[\d.]+$", ranges[name])
        assert low, f"{name} has no range: {ranges[name]}"
        assert f"{version}.0".startswith(f"{low.group(1)}."), f"{name}: {version}, {ranges[name]}"


def test_each_dependency_is_named_once() -> None:
    setup = setup_of("RUNTIME", "EXTRAS")
    assert isinstance(setup["RUNTIME"], list)
    assert isinstance(setup["EXTRAS"], dict)
    pip = [
        str(requirement).split()[0] for requirement in setup["RUNTIME"] + setup["EXTRAS"]["test"]
    ]
    rosdep = [f"{element.tag} {element.text}" for element in MANIFEST if "depend" in element.tag]
    for names in (pip, rosdep):
        assert sorted(set(names)) == sorted(names)


def test_ros_is_no_requirement_of_pip() -> None:
    """Where ROS comes from its own packages, pip must not look for it."""
    assert not {name for name in runtime() if name.startswith("ros-") or is_ros(name)}


def test_licence_is_apache() -> None:
    assert MANIFEST.findtext("license") == "Apache-2.0"
    assert setup_of("license") == {"license": "Apache-2.0"}
    text = (ROOT / "LICENSE").read_text()
    assert "Apache License" in text
    assert "Version 2.0, January 2004" in text
    assert "END OF TERMS AND CONDITIONS" in text


def test_ci_runs_without_further_ado() -> None:
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    subprocess.run(["bash", "-n", str(script)], check=True)
    assert "set -euo pipefail" in script.read_text()


def test_no_file_names_a_place_on_a_developers_machine() -> None:
    place = re.compile(r"(?<![\w.~*$}-])/(?:home|root|work|Users)/[\w.]")
    found = []
    for file in tracked():
        try:
            lines = file.read_text(encoding="utf-8").splitlines()
        except UnicodeDecodeError:
            continue
        found += [
            f"{file.relative_to(ROOT)}:{number}: {line.strip()[:100]}"
            for number, line in enumerate(lines, 1)
            if place.search(line)
        ]
    assert not found, "\n".join(found)


def test_nothing_generated_is_tracked() -> None:
    generated = re.compile(r"(^|/)(__pycache__|\.venv|out|build|install|log)/|\.(pyc|nbc|nbi)$")
    names = [str(file.relative_to(ROOT)) for file in tracked()]
    assert [name for name in names if generated.search(name)] == []
