from lagrangian_ff.report.sections.effects import effects_section as effects_section
from lagrangian_ff.report.sections.torque import torque_section as torque_section
from lagrangian_ff.report.sections.tracking import tracking_section as tracking_section
