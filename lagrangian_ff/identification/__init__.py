"""The semi-parametric model: fit, predict, evidence, blocked validation, save and load."""

from lagrangian_ff.lazy import attach

__getattr__, __all__ = attach(__name__, __file__)
