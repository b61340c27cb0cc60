"""Parts of a page: each file turns findings into one `Section`."""

from lagrangian_ff.report.sections.effects import effects_section
from lagrangian_ff.report.sections.torque import torque_section
from lagrangian_ff.report.sections.tracking import tracking_section

__all__ = ["effects_section", "torque_section", "tracking_section"]
