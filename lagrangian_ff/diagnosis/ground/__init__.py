"""What is left of a motion's torque once rigid-body dynamics and known effects are taken away."""

from lagrangian_ff.diagnosis.ground.changing import Changing
from lagrangian_ff.diagnosis.ground.ground import Ground, lay
from lagrangian_ff.diagnosis.ground.prior import Prior
from lagrangian_ff.diagnosis.ground.tuning import sharpen, tune

__all__ = ["Changing", "Ground", "Prior", "lay", "sharpen", "tune"]
