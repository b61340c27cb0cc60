"""Interfaces of ros2_control that no wheel has, built once with ROS' own generators.

`interfaces/` has the message definitions of control_msgs and controller_manager_msgs that the tests
need, with the names and fields of Jazzy, so that they are the same on the wire. The build takes a
minute and is kept in the environment.
"""

import ctypes
import fcntl
import hashlib
import importlib
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

SOURCES = Path(__file__).parent / "interfaces"
PACKAGES = ("control_msgs", "controller_manager_msgs")
# Where the wheels were made: their CMake files name the headers of that machine.
ELSEWHERE = {
    r"/opt/python/[^;\"]*/numpy/_?core/include": np.get_include(),
    r"/opt/python/[^;\"/]*/include/python[0-9.]*": sysconfig.get_paths()["include"],
}


def interfaces() -> dict[str, str]:
    """Return the variables with which a process finds the interfaces; build them if need be.

    Where ROS has the packages itself none are needed. Where nothing can be built the test is
    skipped, and says what is missing.
    """
    if all(importlib.util.find_spec(name) for name in PACKAGES):
        return {}
    place = Path(sys.prefix) / "interfaces"
    place.mkdir(exist_ok=True)
    with (place / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        built = place / _digest()
        if not (built / "complete").exists():
            _require_tools()
            shutil.rmtree(built, ignore_errors=True)
            _build(built)
            (built / "complete").touch()
    site = built / "lib" / f"python{sys.version_info[0]}.{sys.version_info[1]}" / "site-packages"
    return {
        "PYTHONPATH": _joined(site, "PYTHONPATH"),
        "LD_LIBRARY_PATH": _joined(built / "lib", "LD_LIBRARY_PATH"),
        "AMENT_PREFIX_PATH": os.pathsep.join([str(built), sys.prefix]),
    }


def use(patch: pytest.MonkeyPatch) -> None:
    """Make the interfaces known to this process, and to those that it starts."""
    for name, value in interfaces().items():
        patch.setenv(name, value)
        first = value.split(os.pathsep)[0]
        if name == "PYTHONPATH":
            patch.syspath_prepend(first)
        if name == "LD_LIBRARY_PATH":
            # The loader of this process read the variable when it started.
            for library in sorted(Path(first).glob("lib*_c.so")):
                ctypes.CDLL(str(library))
    importlib.invalidate_caches()


def _joined(first: Path, name: str) -> str:
    return os.pathsep.join(filter(None, [str(first), os.environ.get(name, "")]))


def _digest() -> str:
    digest = hashlib.sha256(sys.version.encode())
    for path in [Path(__file__), *sorted(SOURCES.rglob("*.*"))]:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def _require_tools() -> None:
    path = _path()
    tools = [name for name in ("cmake", "ninja", "gcc", "g++") if not shutil.which(name, path=path)]
    share = Path(sys.prefix) / "share"
    generators = ("ament_cmake", "rosidl_default_generators", "rosidl_generator_py")
    missing = tools + [name for name in generators if not (share / name).exists()]
    if not (Path(sysconfig.get_paths()["include"]) / "Python.h").exists():
        missing.append("Python.h")
    if missing:
        pytest.skip(f"control_msgs cannot be built here: no {', '.join(missing)}")


def _path() -> str:
    return os.pathsep.join([str(Path(sys.prefix) / "bin"), os.environ["PATH"]])


def _build(prefix: Path) -> None:
    """Build all packages into this folder; fail with the end of the output."""
    base = prefix / "base"
    base.mkdir(parents=True)
    shutil.copytree(Path(sys.prefix) / "share", base / "share")
    for name in ("lib", "include"):
        (base / name).symlink_to(Path(sys.prefix) / name)
    for path in base.glob("share/*/cmake/*.cmake"):
        text = path.read_text()
        for found, here in ELSEWHERE.items():
            text = re.sub(found, here, text)
        path.write_text(text)
    environment = {
        **os.environ,
        "AMENT_PREFIX_PATH": str(base),
        "CMAKE_PREFIX_PATH": str(base),
        "PATH": _path(),
    }
    for package in PACKAGES:
        build = prefix / "build" / package
        _run(
            [
                "cmake", "-G", "Ninja", "-S", SOURCES / package, "-B", build,
                f"-DCMAKE_INSTALL_PREFIX={prefix}", f"-DPython3_EXECUTABLE={sys.executable}",
                "-DCMAKE_POLICY_VERSION_MINIMUM=3.5", "-DBUILD_TESTING=OFF",
                "-DCMAKE_CXX_FLAGS=-O0", "-DCMAKE_C_FLAGS=-O0",
                f"-DCMAKE_INSTALL_RPATH={prefix / 'lib'};{Path(sys.prefix) / 'lib'}",
            ],
            environment,
        )  # fmt: skip
        _run(["cmake", "--build", build, "--target", "install"], environment)
    shutil.rmtree(prefix / "build")


def _run(command: list[str | Path], environment: dict[str, str]) -> None:
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, f"{command}:\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"


@contextmanager
def follow_joint_trajectory() -> Iterator[Any]:
    """Yield the type of the action, for this process and for those that it starts."""
    with pytest.MonkeyPatch.context() as patch:
        use(patch)
        yield importlib.import_module("control_msgs.action").FollowJointTrajectory
        for name in [name for name in sys.modules if name.startswith("control_msgs")]:
            del sys.modules[name]


if __name__ == "__main__":
    # `make test` builds them while mypy has the other processor.
    try:
        interfaces()
    except pytest.skip.Exception as reason:
        print(reason)
