"""A Python whose package index is imagined, to try the set-up without installing anything.

It passes for the version that its settings name, makes environments that hold only itself, and
answers pip from the settings, a JSON file named ``settings.json`` beside it: ``version``, ``wheel``
(is there one of PyBullet), ``index`` (does the index answer), ``fail`` (pip cannot install) and
``calls`` (where every use of pip is noted).
"""

import json
import platform
import runpy
import shutil
import sys
from pathlib import Path

HERE = Path(sys.argv[0]).absolute()
SETTINGS = json.loads((HERE.parent / "settings.json").read_text())


def make_environment(directory: Path) -> int:
    """Make what passes for a virtual environment."""
    (directory / "bin").mkdir(parents=True)
    (directory / "pyvenv.cfg").touch()
    shutil.copy(HERE, directory / "bin" / "python")
    shutil.copy(HERE.parent / "settings.json", directory / "bin")
    command = directory / "bin" / "lagrangian_ff"
    command.write_text('#!/bin/sh\necho "PYTHONPATH=$PYTHONPATH"\necho "ran: lagrangian_ff $*"\n')
    command.chmod(0o755)
    return 0


def pip(arguments: list[str]) -> int:
    """Answer as pip would."""
    with Path(SETTINGS["calls"]).open("a") as calls:
        calls.write(" ".join(arguments) + "\n")
    if arguments[:2] == ["index", "versions"]:
        return 0 if SETTINGS["index"] else 1
    if "--only-binary" in arguments:
        return 0 if SETTINGS["wheel"] else 1
    if "--editable" in arguments and SETTINGS["fail"]:
        print("ERROR: the disk is full")
        return 1
    return 0


def main() -> int:
    """Do what the arguments ask of a Python."""
    sys.executable = str(HERE)
    version = tuple(SETTINGS["version"])
    if sys.argv[1:3] == ["-m", "venv"]:
        return make_environment(Path(sys.argv[3]))
    if sys.argv[1:3] == ["-m", "pip"]:
        return pip(sys.argv[3:])
    if sys.argv[1] == "-c":
        return 0
    sys.version_info = version  # type: ignore[assignment]
    platform.python_version = lambda: ".".join(map(str, version))
    sys.argv = sys.argv[1:]
    runpy.run_path(sys.argv[0], run_name="__main__")
    return 0


if __name__ == "__main__":
    sys.exit(main())
