"""The checks, listed once, and their order."""

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
from lagrangian_ff.diagnosis.preflight.effort import check_sign, check_unit
from lagrangian_ff.diagnosis.preflight.noise import check_noise
from lagrangian_ff.diagnosis.preflight.saturation import check_saturation
from lagrangian_ff.identification import Model
from lagrangian_ff.recording.motion import Motion

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
"""What is looked at before any effect is blamed; a new check is one function here."""


def preflight(model: Model, motion: Motion, others: Sequence[Motion] = ()) -> list[Check]:
    """Look at the measurement before blaming the physics.

    Args:
        model: the model.
        motion: measured; may hold more joints than the model, in any order.
        others: further recordings, in which the same motion may occur again.

    Returns:
        What was found, serious things first.

    Raises:
        ModelError: a recording lacks a joint of the model.
    """
    case = Case.of(model, motion, others)
    found = [check for look in CHECKS for check in look(case)]
    return sorted(found, key=lambda check: not check.serious)
