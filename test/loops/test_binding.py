"""The compiled loops are those of their sources, run in every variant, and refuse what is wrong."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import numpy as np
import pytest

import lagrangian_ff
from lagrangian_ff.loops import build, loop

ROOT = Path(__file__).resolve().parents[2]
FOLDER = Path(lagrangian_ff.__file__).parent / "loops"
USE = """
import numpy as np
from lagrangian_ff.loops import loop
from lagrangian_ff.errors import UserError
try:
    loop("exponentials")(1, np.array([-1.0]), np.empty(1))
except UserError as error:
    print(error)
"""


def copied(folder: Path) -> Path:
    """Return a copy of the parts of the package that the loops need, with its sources."""
    package = folder / "lagrangian_ff"
    shutil.copytree(FOLDER, package / "loops")
    for name in ("__init__.py", "errors.py"):
        shutil.copy(FOLDER.parent / name, package / name)
    return package / "loops"


def used(folder: Path) -> str:
    """Return what Python says that uses the loops in a folder."""
    done = subprocess.run(
        [sys.executable, "-c", USE], env={**os.environ, "PYTHONPATH": str(folder)}, cwd=folder,
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return done.stdout


beside = pytest.mark.skipif(
    not any(FOLDER.glob("*.so")),
    reason="the libraries are not beside the sources, as in colcon test",
)


@beside
@pytest.mark.parametrize("variant", build.variants())
def test_every_variant_is_built_of_these_sources(variant: str) -> None:
    library = ctypes.CDLL(str(FOLDER / f"{variant}{sysconfig.get_config_var('EXT_SUFFIX')}"))
    library.loops_sources.restype = ctypes.c_char_p
    assert library.loops_sources().decode() == build.digest()


def test_an_array_of_another_kind_is_refused() -> None:
    out = np.empty(3)
    for wrong in (np.zeros(3, np.float32), np.zeros(6)[::2], np.zeros(3, np.int64)):
        with pytest.raises(ctypes.ArgumentError, match="expected a C-contiguous array of float64"):
            loop("exponentials")(3, wrong, out)


def test_what_may_not_be_written_can_be_read() -> None:
    x, out = np.zeros(3), np.empty(3)
    x.flags.writeable = False
    loop("exponentials")(3, x, out)
    assert (out == 1.0).all()


@beside
def test_changed_sources_are_not_run(tmp_path: Path) -> None:
    loops = copied(tmp_path)
    assert used(tmp_path) == ""
    (loops / "memory.c").write_text((loops / "memory.c").read_text() + "\n")
    assert "not those of the sources beside them: run `pip install -e .`" in used(tmp_path)


def test_what_is_not_compiled_says_what_to_do(tmp_path: Path) -> None:
    for library in copied(tmp_path).glob("*.so"):
        library.unlink()
    assert "the C loops are not compiled" in used(tmp_path)
    assert "make install" in used(tmp_path)


@pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")
def test_the_loops_compile_without_a_warning(tmp_path: Path) -> None:
    sources = [str(FOLDER / name) for name in build.SOURCES]
    flags = [*build.FLAGS, "-O1", "-Werror", "-fPIC", "-shared", '-DSOURCES=""', "-lm"]
    command = ["gcc", *sources, *flags, "-o", str(tmp_path / "loops.so")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
