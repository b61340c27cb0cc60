"""The memory that a model takes, and the refusal of one that does not fit."""

from collections.abc import Callable
from math import isqrt
from pathlib import Path

from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.blueprint import Blueprint
from lagrangian_ff.kernels import CoupledKernel

COPIES = 4
"""Square matrices of doubles held at once: the Gram matrix, its copy that is factored, the inverse
factor for the blocks left out, and a part of another; on inducing points the Gram matrix,
the sum of all folds, a sum without one, and its factor."""
SHARE = 0.9
"""Share of the free memory that a model may take."""
MEMINFO, GROUPS = Path("/proc/meminfo"), Path("/sys/fs/cgroup")
LIMITS = (
    ("memory.max", "memory.current", "memory.stat"),
    ("memory/memory.limit_in_bytes", "memory/memory.usage_in_bytes", "memory/memory.stat"),
)
"""Limit, use and its parts in a control group of version 2 and of version 1: a container's."""


def available(meminfo: Path = MEMINFO, groups: Path = GROUPS) -> int | None:
    """Return the bytes that this process may take, the least of machine and container.

    None if the system does not report them.
    """
    free = [_machine(meminfo), *(_left(*(groups / name for name in names)) for names in LIMITS)]
    return min((one for one in free if one is not None), default=None)


def needed(centres: int, joints: int, *, coupled: bool = True, folds: int | None = None) -> int:
    """Return the bytes that building a model takes.

    Joints that are coupled are one system of centres × joints equations, others are solved apart,
    and their factors are kept. On inducing points, sums over each fold take the place of factors.

    Args:
        centres: samples that the kernel is built on.  joints: of the arm.
        coupled: whether the kernel couples them.
        folds: on inducing points, the number of sums; None for an exact model.
    """
    copies = COPIES if folds is None else folds + COPIES
    if coupled:
        return copies * 8 * (centres * joints) ** 2
    return copies * 8 * centres**2 * joints


def require_memory(
    centres: int,
    joints: int,
    *,
    coupled: bool = True,
    folds: int | None = None,
    free: Callable[[], int | None] | None = None,
) -> None:
    """Refuse a model that does not fit, before any of it is computed.

    Args:
        centres, joints, coupled, folds: see `needed`.
        free: returns the free memory in bytes; None, if it is unknown, refuses nothing. By
            default that of this machine.

    Raises:
        ModelError: says how much memory is needed, how much there is, and how many centres fit.
    """
    bytes_free = (free or available)()
    wanted = needed(centres, joints, coupled=coupled, folds=folds)
    if bytes_free is None or wanted <= SHARE * bytes_free:
        return
    fit = isqrt(int(SHARE * bytes_free) // needed(1, joints, coupled=coupled, folds=folds))
    what = "samples" if folds is None else "inducing points"
    raise ModelError(
        f"a model of {centres} {what} of {joints} joints needs {_gigabytes(wanted)} of memory, "
        f"{_gigabytes(bytes_free)} are free: use at most {fit} {what} "
        f"(--{what.replace(' ', '-')} {fit})"
    )


def require_room(blueprint: Blueprint, subset: int) -> None:
    """Refuse a blueprint whose model, or the exact fits of its subset, do not fit.

    Raises:
        ModelError: see `require_memory`.
    """
    joints = len(blueprint.data.joints)
    coupled = isinstance(blueprint.prior.kernel, CoupledKernel)
    require_memory(subset, joints, coupled=coupled)
    if not blueprint.exact:
        folds = blueprint.settings.folds
        require_memory(len(blueprint.index), joints, coupled=coupled, folds=folds)


def _machine(meminfo: Path) -> int | None:
    try:
        lines = meminfo.read_text().splitlines()
    except OSError:
        return None
    found = [line.split() for line in lines if line.startswith("MemAvailable:")]
    return int(found[0][1]) * 1024 if found else None


def _left(limit: Path, used: Path, parts: Path) -> int | None:
    """Return what is left of a limit, file cache included, which gives way; None without one."""
    try:
        table = dict(line.split() for line in parts.read_text().splitlines())
        return max(0, int(limit.read_text()) - int(used.read_text()) + int(table["inactive_file"]))
    except (OSError, ValueError, KeyError):  # "max" is no number: no limit
        return None


def _gigabytes(count: int) -> str:
    return f"{count / 1e9:.3g} GB"
