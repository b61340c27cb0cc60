"""The interface of a target: clean files, and what a user does with one."""

import io
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random

import numpy as np

from lagrangian_ff.recording import Recording

_MOST = 16 << 20
"""Bytes of an archive whose members are damaged."""


@dataclass(frozen=True)
class Target:
    """A reader to be fuzzed.

    Attributes:
        name: of the target.
        seeds: writes the clean files, small ones, into a folder.
        read: does what a user does with such a file; raises UserError if it is refused.
        tokens: bytes that have a meaning in these files.
        archive: whether the files are zip archives, whose members are damaged, too.
        deeper: damages what flipped bytes do not reach; None if there is nothing.
    """

    name: str
    seeds: Callable[[Path], None]
    read: Callable[[Path], None]
    tokens: tuple[bytes, ...] = ()
    archive: bool = False
    deeper: Callable[[bytes, Random], bytes] | None = None


def swinging(samples: int = 300, joints: int = 3, rate: float = 200.0) -> Recording:
    """Return a recording of joints that swing, each at its speed."""
    time = np.round(np.arange(samples) / rate, 9)
    omega = 2 * np.pi * (0.7 + 0.3 * np.arange(joints, dtype=np.float64))
    angle = np.outer(time, omega)
    names = tuple(f"joint_{number}" for number in range(1, joints + 1))
    effort = 3.0 + 2.0 * np.cos(angle) - omega**2 * np.sin(angle)
    return Recording(names, time, np.sin(angle), omega * np.cos(angle), effort, start=1.7e9)


def members(data: bytes) -> dict[str, bytes] | None:
    """Return the files in a zip by name; None if it is damaged, as a search makes it, or huge."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if sum(one.file_size for one in archive.infolist()) > _MOST:
                return None
            return {name: archive.read(name) for name in archive.namelist()}
    except Exception:
        return None


def packed(files: dict[str, bytes]) -> bytes:
    """Return a zip of files."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return out.getvalue()
