"""Where and how a model differs from what was measured."""

from lagrangian_ff.diagnosis.compare import Comparison, compare

__all__ = ["Comparison", "compare"]
