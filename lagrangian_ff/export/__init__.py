"""A model in a form that other programs run: one file a format, listed in `formats`."""

from lagrangian_ff.export.formats import FORMATS, write
from lagrangian_ff.export.result import Exported, Loss, Options

__all__ = ["FORMATS", "Exported", "Loss", "Options", "write"]
