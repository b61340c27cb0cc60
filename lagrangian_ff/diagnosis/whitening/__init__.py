"""The whitened problem: the residual of rigid-body dynamics and known effects."""

from lagrangian_ff.diagnosis.whitening.changing import Changing
from lagrangian_ff.diagnosis.whitening.hyperparameters import fit, fit_for, refit
from lagrangian_ff.diagnosis.whitening.outliers import counting_less, in_full, outweighed
from lagrangian_ff.diagnosis.whitening.whitened import Whitened, whiten

__all__ = [
    "Changing",
    "Whitened",
    "counting_less",
    "fit",
    "fit_for",
    "in_full",
    "outweighed",
    "refit",
    "whiten",
]
