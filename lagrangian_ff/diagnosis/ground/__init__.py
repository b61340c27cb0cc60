"""What is left of a motion's torque once rigid-body dynamics and known effects are taken away."""

from lagrangian_ff.diagnosis.ground.ground import Ground, lay
from lagrangian_ff.diagnosis.ground.prior import Prior
from lagrangian_ff.diagnosis.ground.tuning import evidence_of, sharpen, tune

__all__ = ["Ground", "Prior", "evidence_of", "lay", "sharpen", "tune"]
