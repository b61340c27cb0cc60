"""All formats, in the order in which they are listed."""

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import cast

from lagrangian_ff.errors import ExportError
from lagrangian_ff.export.result import Exported, Format, Options
from lagrangian_ff.identification import Model

_FILES = ("c_package", "json_file", "onnx_file", "urdf_file", "mjcf_file", "ur_program")
"""The file of each format, beside this one. A new format is its file and its name here."""

FORMATS: Mapping[str, Format] = {
    made.NAME: made
    for made in (cast(Format, import_module(f"lagrangian_ff.export.{file}")) for file in _FILES)
}
"""Every format by its name."""


def write(model: Model, to: str, path: Path, options: Options | None = None) -> Exported:
    """Write a model in a format.

    Args:
        to: name of the format.  path: the file, or folder, that is made.

    Raises:
        ExportError: there is no such format, it cannot hold the model, or lacks the robot's URDF;
            says what is missing.
    """
    if to not in FORMATS:
        raise ExportError(f"there is no format '{to}'; there are {', '.join(FORMATS)}")
    form, options = FORMATS[to], options or Options()
    if form.URDF and options.urdf is None:
        raise ExportError(f"the format {to} describes the robot's bodies: give --urdf ROBOT.urdf")
    return form.write(model, path, options)
