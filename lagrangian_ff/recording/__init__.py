"""Recordings, their inspection, and the motion made of them."""

from lagrangian_ff.lazy import attach

__getattr__, __all__ = attach(__name__, __file__)
