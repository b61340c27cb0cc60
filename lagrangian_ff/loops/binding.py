"""The compiled loops, as functions of NumPy arrays."""

import ctypes
import sys
import sysconfig
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.errors import UserError
from lagrangian_ff.loops import build


class _Array:
    """An argument that is an array of one type, C-contiguous."""

    dtype: ClassVar[np.dtype[Any]]

    @classmethod
    def from_param(cls, array: NDArray[Any]) -> Any:
        """Return the address; called by ctypes for every argument, so that it must be quick."""
        if array.dtype != cls.dtype or not array.flags.c_contiguous:
            raise TypeError(
                f"expected a C-contiguous array of {cls.dtype}, got {array.dtype} with strides"
                f" {array.strides} for the shape {array.shape}"
            )
        try:
            return ctypes.byref(ctypes.c_char.from_buffer(array))  # type: ignore[arg-type]
        except (TypeError, ValueError):  # it is read-only, or empty
            return ctypes.c_void_p(array.ctypes.data)


class _Doubles(_Array):
    dtype = np.dtype(np.float64)


class _Integers(_Array):
    dtype = np.dtype(np.int64)


_KINDS: dict[str, Any] = {
    "i": ctypes.c_int,
    "A": ctypes.c_void_p,
    "d": ctypes.c_double,
    "D": _Doubles,
    "I": _Integers,
}
_STRUCTURED = "iiID"  # joints, serial, form, numbers
_UNIVERSAL = "iiDD"  # joints, angles, alpha, w

_ARGUMENTS = {
    "structured_blocks": _STRUCTURED + "DDIiiD",
    "structured_potential": _STRUCTURED + "DiDiDD",
    "structured_contract": _STRUCTURED + "DiIiIDDDDDD",
    "universal_blocks": _UNIVERSAL + "DDIiiD",
    "universal_diagonal": _UNIVERSAL + "DiDiiD",
    "universal_diagonal_apply": _UNIVERSAL + "DiDiiDD",
    "universal_variance": _UNIVERSAL + "DiD",
    "universal_lagrangian_rows": _UNIVERSAL + "DiDiD",
    "universal_lagrangian": _UNIVERSAL + "DiDiDDD",
    "centres_apply": _UNIVERSAL + "DiDiD",
    "polynomial_torques": "iDDDiDDDD",
    "rigid_regressor": "iiiDDDIDDDDIDDDD",
    "clock_ticks": "iDDDIDiI",
    "memory_stop": "iDIDdD",
    "memory_loose": "iDDdddD",
    "memory_filter": "iDDD",
    "exponentials": "iDD",
    "arm_currents": "A",
    "arm_guess": "A",
    "arm_settle": "Ai",
    "arm_move": "Ai",
    "arm_step": "Ai",
}
"""A letter for each argument, in the order of the C function: i an int, d a double, D and I arrays
of doubles and of 64-bit integers, A an address of numbers laid out as the C file says."""

_ALLOCATING = (
    "structured_blocks",
    "structured_potential",
    "structured_contract",
    "centres_apply",
    "polynomial_torques",
    "rigid_regressor",
    "clock_ticks",
)


class LoopsError(UserError):
    """The loops are not compiled, or from other sources."""


@cache
def loop(name: str) -> Callable[..., None]:
    """Return a compiled loop; what it does stands beside its name in the C files.

    It runs without Python's lock, so that threads may share the work.

    Raises:
        LoopsError: see `LoopsError`.
        MemoryError: by the function, where there is none.
        ctypes.ArgumentError: by the function; an array of another type or layout.
    """
    function = getattr(_library(), name)
    function.argtypes = [_KINDS[kind] for kind in _ARGUMENTS[name]]
    if name in _ALLOCATING:
        function.errcheck = _require_memory
    else:
        function.restype = None
    return function


def _require_memory(had: int, function: object, arguments: object) -> None:
    if not had:
        raise MemoryError


@cache
def _library() -> ctypes.CDLL:
    """Load the fastest library that this processor runs."""
    plain = _load(build.PLAIN)
    plain.loops_level.restype = ctypes.c_char_p
    level = plain.loops_level().decode()
    return _load(level) if level in build.variants() else plain


def _file(variant: str) -> Path:
    """Return the file of a library: beside this one, or where the package is installed.

    `colcon test` runs the sources, which are not compiled, beside what it has installed.
    """
    name = variant + str(sysconfig.get_config_var("EXT_SUFFIX"))
    own = Path(__file__).parent
    installed = (Path(entry, *own.parts[-2:]) for entry in sys.path)
    return next((path / name for path in (own, *installed) if (path / name).exists()), own / name)


def _load(variant: str) -> ctypes.CDLL:
    path = _file(variant)
    mend = "run `pip install -e .` in the source folder (`make install` in a clone)"
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise LoopsError(f"the C loops are not compiled ({error}): {mend}") from error
    library.loops_sources.restype = ctypes.c_char_p
    # In a clone, the sources beside the library may have been changed since.
    if build.SOURCES and library.loops_sources().decode() != build.digest():
        raise LoopsError(f"the C loops in {path} are not those of the sources beside them: {mend}")
    return library
