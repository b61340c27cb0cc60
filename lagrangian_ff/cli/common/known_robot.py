"""The robot that --urdf names."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lagrangian_ff.kernels import Mechanism


def known_robot(path: Path | None) -> "Mechanism | None":
    """What the file describes; None where none was given.

    Raises:
        UserError: it cannot be read.
    """
    if path is None:
        return None
    from lagrangian_ff.kernels.rigid import read_urdf

    return read_urdf(path)
