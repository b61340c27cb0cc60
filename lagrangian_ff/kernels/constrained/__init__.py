"""Mechanisms with closed loops: eq. (48) of the paper."""

from lagrangian_ff.kernels.constrained.five_bar import FiveBar
from lagrangian_ff.kernels.constrained.linkage import Linkage

__all__ = ["FiveBar", "Linkage"]
