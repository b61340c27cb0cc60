"""The motion to record next: it shows an effect, or separates it from its look-alikes."""

from lagrangian_ff.diagnosis.excite.excite import excite, seen_pose
from lagrangian_ff.diagnosis.excite.motions import NEXT_MOTIONS, NextMotion
from lagrangian_ff.diagnosis.excite.path import Limits, Reference

__all__ = ["NEXT_MOTIONS", "Limits", "NextMotion", "Reference", "excite", "seen_pose"]
