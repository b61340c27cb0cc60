"""The format `c`: a C99 library without dependencies, with CMake package and pkg-config file."""

from pathlib import Path

from lagrangian_ff.export.c_source import sources
from lagrangian_ff.export.portable import portable
from lagrangian_ff.export.result import Exported, Options, exported, settled_losses, settled_torque
from lagrangian_ff.identification import Model

NAME = "c"
SUMMARY = "a C99 library: a header, a file, CMake package and pkg-config file"
SUFFIX = ""
URDF = False


def write(model: Model, path: Path, options: Options) -> Exported:
    """Write the folder of a C library of the folder's name; see `Format`."""
    held = portable(model, settled=options.settled)
    made = sources(model, held, path.name)
    path.mkdir()
    for name, text in made.items():
        (path / name).write_text(text, encoding="utf-8")
    losses = settled_losses(model, held.settled)
    return exported(model, NAME, (".", *made), settled_torque(model), losses)
