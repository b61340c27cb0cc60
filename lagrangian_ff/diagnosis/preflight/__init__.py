"""Faults of the measurement that look like missing physics."""

from lagrangian_ff.diagnosis.preflight.base import Case, Check
from lagrangian_ff.diagnosis.preflight.preflight import CHECKS, preflight

__all__ = ["CHECKS", "Case", "Check", "preflight"]
