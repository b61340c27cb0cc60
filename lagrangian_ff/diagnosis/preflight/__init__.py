"""Faults of the measurement that look like missing physics: the checks, in order.

A new check is one function in `CHECKS`.
"""

from collections.abc import Callable, Sequence

from lagrangian_ff.diagnosis.preflight.base import Case, Check
from lagrangian_ff.diagnosis.preflight.coverage import (
    check_duration,
    check_range,
    check_speeds,
    check_stamps,
    check_still,
)
from lagrangian_ff.diagnosis.preflight.delay import check_delay
from lagrangian_ff.diagnosis.preflight.effort import check_saturation, check_sign, check_unit
from lagrangian_ff.diagnosis.preflight.noise import check_noise
from lagrangian_ff.identification import Model
from lagrangian_ff.recording.motion import Motion

__all__ = ["CHECKS", "Case", "Check", "preflight"]

CHECKS: tuple[Callable[[Case], list[Check]], ...] = (
    check_sign,
    check_unit,
    check_saturation,
    check_delay,
    check_range,
    check_stamps,
    check_still,
    check_duration,
    check_speeds,
    check_noise,
)
"""The checks that run before any effect is blamed."""


def preflight(model: Model, motion: Motion, others: Sequence[Motion] = ()) -> list[Check]:
    """Return the faults that the checks find in a measurement, serious ones first.

    Args:
        motion: measured; may hold more joints than the model, in any order.
        others: further recordings, in which the same motion may occur again.

    Raises:
        ModelError: a recording lacks a joint of the model.
    """
    case = Case.of(model, motion, others)
    found = [check for look in CHECKS for check in look(case)]
    return sorted(found, key=lambda check: not check.serious)
