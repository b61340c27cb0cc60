"""The semi-parametric model: fit, predict, evidence, blocked validation, save and load."""

from lagrangian_ff.identification.identify import Identification, Settings, identify
from lagrangian_ff.identification.model import Model, Terms
from lagrangian_ff.identification.motion_range import MotionRange
from lagrangian_ff.identification.score import Score

__all__ = [
    "Identification",
    "Model",
    "MotionRange",
    "Score",
    "Settings",
    "Terms",
    "identify",
]
