"""The wheel works on another Python than this one, outside the sources; `make wheels` tries all."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import environment  # noqa: E402
from wheels import COMMANDS, PYTHONS, StepError, copy_sources, python_of, pythons, tried  # noqa: E402

HERE = f"{sys.version_info[0]}.{sys.version_info[1]}"
FIRST = ("3.12", "3.13", "3.10", "3.11")
"""In what order others are looked for: Ubuntu's first."""


def test_the_wheel_works_on_another_python(tmp_path: Path) -> None:
    other = next(iter(pythons([version for version in FIRST if version != HERE])), None)
    if other is None:
        pytest.skip(f"there is no Python from {PYTHONS[0]} to {PYTHONS[-1]} but this one")
    asked = subprocess.run(
        [sys.executable, "-m", "pip", "index", "versions", "wheel"],
        capture_output=True,
        check=False,
    )
    if asked.returncode != 0:
        pytest.skip("the package index does not answer")
    taken = tried(other, tmp_path / "tried")
    assert set(taken) >= {name for name, _ in COMMANDS}


def test_a_python_that_does_not_run_is_passed_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As pyenv's, which are on the path for every version that it has."""
    broken, right = tmp_path / "broken", tmp_path / "right"
    for folder, text in ((broken, "exit 127"), (right, f'exec "{sys.executable}" "$@"')):
        folder.mkdir()
        (folder / f"python{HERE}").write_text(f"#!/bin/sh\n{text}\n")
        (folder / f"python{HERE}").chmod(0o755)
    monkeypatch.setenv("PATH", str(broken))
    assert python_of(HERE) is None
    monkeypatch.setenv("PATH", f"{broken}:{right}")
    found = python_of(HERE)
    assert found is not None
    assert found.path.parent == right
    (right / "python3.99").write_text((right / f"python{HERE}").read_text())
    (right / "python3.99").chmod(0o755)
    assert python_of("3.99") is None, "it is another version than its name says"


def test_a_python_of_pyenv_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    programs = tmp_path / "3.8.1" / "bin"
    programs.mkdir(parents=True)
    (programs / f"python{HERE}").write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    (tmp_path / "pyenv").write_text(
        f'#!/bin/sh\nif [ "$1" = versions ]; then echo system; echo {HERE}.7; else echo '
        f'"{programs.parent}"; fi\n'
    )
    for path in (programs / f"python{HERE}", tmp_path / "pyenv"):
        path.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    found = python_of(HERE)
    assert found is not None
    assert found.path == programs / f"python{HERE}"


def test_a_step_that_fails_is_named(tmp_path: Path) -> None:
    found = python_of(HERE)
    if found is None:
        pytest.skip("this Python is not on the path")
    (tmp_path / "venv").write_text("in the way of the environment")
    with pytest.raises(StepError, match=f"Python {HERE}: environment failed"):
        tried(found, tmp_path)


def test_a_compiler_is_brought_only_where_there_is_none(tmp_path: Path) -> None:
    """Pip builds in an environment that has what the package asks for, and nothing else."""
    copy_sources(tmp_path / "source")
    programs = tmp_path / "programs"
    programs.mkdir()
    asked = "from setuptools.build_meta import *; print(get_requires_for_build_wheel())"
    said = []
    for _ in ("no compiler", "one"):
        done = subprocess.run(
            [sys.executable, "-c", asked], cwd=tmp_path / "source", env={"PATH": str(programs)},
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        said.append("ziglang" in done.stdout.splitlines()[-1])
        (programs / "cc").write_text("")
        (programs / "cc").chmod(0o755)
    assert said == [True, False]


def test_all_name_the_same_pythons() -> None:
    text = (ROOT / "setup.py").read_text()
    assert tuple(re.findall(r'"Programming Language :: Python :: (3\.\d+)"', text)) == PYTHONS
    assert f'python_requires=">={PYTHONS[0]}"' in text
    oldest, newest = (".".join(map(str, v)) for v in (environment.OLDEST, environment.NEWEST))
    assert (oldest, newest) == (PYTHONS[0], PYTHONS[-1])
    assert f"Python {oldest} to {newest}" in (ROOT / "docs" / "installing.md").read_text()
