"""How the C loops are compiled: read by setup.py, which runs before the package is installed."""

import hashlib
import os
import platform
import shutil
import sys
from importlib.util import find_spec
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
SOURCES = sorted(path.name for path in FOLDER.glob("*.c"))
HEADERS = sorted(path.name for path in FOLDER.glob("*.h"))
FLAGS = [
    "-O3",
    "-std=gnu11",
    "-fvisibility=hidden",
    "-fopenmp-simd",
    "-ffp-contract=fast",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-Wall",
    "-Wextra",
]

PLAIN = "plain"
_AVX2 = ["-mavx2", "-mfma"]
LEVELS = {
    "avx2": _AVX2,
    "avx512": [*_AVX2, *(f"-mavx512{part}" for part in ("f", "dq", "bw", "vl"))],
}
"""For processors of 2015 and later, and for large ones; `library.c` knows which this one is."""


def variants() -> dict[str, list[str]]:
    """Return the flags of each library that is built on this machine, by its name."""
    faster = LEVELS if platform.machine().lower() in ("x86_64", "amd64") else {}
    return {PLAIN: FLAGS, **{name: [*FLAGS, *flags] for name, flags in faster.items()}}


def digest() -> str:
    """Return a digest of the sources and of how they are compiled; empty where there are none."""
    if not SOURCES:
        return ""
    found = hashlib.sha256(repr(variants()).encode())
    for name in (*SOURCES, *HEADERS):
        found.update((FOLDER / name).read_bytes())
    return found.hexdigest()[:16]


def choose_compiler() -> None:
    """Let the environment name the compiler of the package `ziglang` where there is no other.

    Raises:
        SystemExit: there is none at all; it says what to install.
    """
    if os.environ.get("CC") or any(shutil.which(name) for name in ("cc", "gcc", "clang")):
        return
    if find_spec("ziglang") is None:
        raise SystemExit(
            "lagrangian_ff compiles its loops from C, and no C compiler was found. Install one"
            " (Debian, Ubuntu: apt install gcc libc6-dev), or: pip install ziglang"
        )
    # Without a target it compiles for this very processor.
    target = f"{platform.machine()}-linux-gnu"
    os.environ["CC"] = f"{sys.executable} -m ziglang cc -target {target}"
    os.environ["LDSHARED"] = f"{os.environ['CC']} -shared"
