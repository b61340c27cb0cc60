"""The semi-parametric model: fit, predict, evidence, blocked validation, save and load."""

from lagrangian_ff.identification.build import Identification
from lagrangian_ff.identification.extend import extend
from lagrangian_ff.identification.identify import identify
from lagrangian_ff.identification.kept import kept
from lagrangian_ff.identification.mechanics.dynamics import Dynamics
from lagrangian_ff.identification.model import Model, Terms
from lagrangian_ff.identification.motion_range import MotionRange
from lagrangian_ff.identification.score import Score
from lagrangian_ff.identification.settings import Settings

__all__ = [
    "Dynamics",
    "Identification",
    "Model",
    "MotionRange",
    "Score",
    "Settings",
    "Terms",
    "extend",
    "identify",
    "kept",
]
