"""The motion to record next: a template by name, or one designed by its information."""

from lagrangian_ff.diagnosis.excite.assumed import Assumed, Expected
from lagrangian_ff.diagnosis.excite.clearance import Box, Clearance, floor_at, urdf_limits
from lagrangian_ff.diagnosis.excite.climbing import Effort
from lagrangian_ff.diagnosis.excite.design import Design, design
from lagrangian_ff.diagnosis.excite.excite import excite, seen_pose
from lagrangian_ff.diagnosis.excite.keeping import limits_of
from lagrangian_ff.diagnosis.excite.motions import NEXT_MOTIONS, NextMotion
from lagrangian_ff.diagnosis.excite.outcome import Outcome, design_record, outcomes
from lagrangian_ff.diagnosis.excite.path import Limits, Reference
from lagrangian_ff.diagnosis.excite.questions import (
    Between,
    Everything,
    For,
    Parameters,
    Question,
    Suspect,
)

__all__ = [
    "NEXT_MOTIONS",
    "Assumed",
    "Between",
    "Box",
    "Clearance",
    "Design",
    "Effort",
    "Everything",
    "Expected",
    "For",
    "Limits",
    "NextMotion",
    "Outcome",
    "Parameters",
    "Question",
    "Reference",
    "Suspect",
    "design",
    "design_record",
    "excite",
    "floor_at",
    "limits_of",
    "outcomes",
    "seen_pose",
    "urdf_limits",
]
