"""The motion to record next: what shows an effect, or tells it from its look-alikes."""

from lagrangian_ff.diagnosis.excite.excite import excite
from lagrangian_ff.diagnosis.excite.limits import Limits
from lagrangian_ff.diagnosis.excite.motions import NEXT_MOTIONS, NextMotion
from lagrangian_ff.diagnosis.excite.path import Reference
from lagrangian_ff.diagnosis.excite.pose import seen_pose

__all__ = ["NEXT_MOTIONS", "Limits", "NextMotion", "Reference", "excite", "seen_pose"]
