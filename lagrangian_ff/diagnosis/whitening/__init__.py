"""The whitened problem: the residual of rigid-body dynamics and known effects."""

from lagrangian_ff.diagnosis.whitening.changing import Changing
from lagrangian_ff.diagnosis.whitening.hyperparameters import fit, refit
from lagrangian_ff.diagnosis.whitening.whitened import Whitened, whiten

__all__ = ["Changing", "Whitened", "fit", "refit", "whiten"]
