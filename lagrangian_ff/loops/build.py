"""How the C loops are compiled: read by setup.py, which runs before the package is installed."""

import hashlib
import os
import platform
import shutil
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

ZIG = "ziglang >=0.13, <0.18"
"""A C compiler from the package index."""
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


def requirements() -> list[str]:
    """Return what has to be installed to compile: nothing, or `ZIG` where there is no compiler."""
    compilers = ("cc", "gcc", "clang")
    return [] if os.environ.get("CC") or any(map(shutil.which, compilers)) else [ZIG]


def choose_compiler() -> None:
    """Let the environment name the compiler of the package `ziglang` where there is no other.

    Raises:
        SystemExit: there is none at all; it says what to install.
    """
    if not requirements():
        return
    found = find_spec("ziglang")
    if found is None or found.origin is None:
        raise SystemExit(
            "lagrangian_ff compiles its loops from C, and no C compiler was found. Install one"
            " (Debian, Ubuntu: apt install gcc libc6-dev), or: pip install ziglang"
        )
    # Without a target it compiles for this very processor.
    compiler = Path(found.origin).with_name("zig")
    os.environ["CC"] = f"{compiler} cc -target {platform.machine()}-linux-gnu"
    os.environ["LDSHARED"] = f"{os.environ['CC']} -shared"
