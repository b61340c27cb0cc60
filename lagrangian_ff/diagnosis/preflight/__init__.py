"""Faults of the measurement that look like missing physics: the checks, in order.

A new check is one function in `CHECKS`.
"""

from collections.abc import Callable, Sequence

import numpy as np

from lagrangian_ff.diagnosis.preflight.base import Case, Check, Remedy
from lagrangian_ff.diagnosis.preflight.clipping import check_saturation
from lagrangian_ff.diagnosis.preflight.coverage import (
    check_duration,
    check_range,
    check_speeds,
    check_stamps,
    check_still,
)
from lagrangian_ff.diagnosis.preflight.delay import check_delay
from lagrangian_ff.diagnosis.preflight.effort import check_sign, check_unit
from lagrangian_ff.diagnosis.preflight.effort_kind import kind_checks
from lagrangian_ff.diagnosis.preflight.noise import check_noise
from lagrangian_ff.diagnosis.preflight.urdf_unit import urdf_unit_checks
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.spec import sliding_of
from lagrangian_ff.kernels.rigid import Robot
from lagrangian_ff.recording.motion import Motion

__all__ = ["CHECKS", "Case", "Check", "Remedy", "effort_checks", "kind_checks", "preflight"]

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


def preflight(
    model: Model, motion: Motion, others: Sequence[Motion] = (), *, kind: bool = True
) -> list[Check]:
    """Return the faults that the checks find in a measurement, serious ones first.

    Args:
        motion: measured; may hold more joints than the model, in any order.
        others: further recordings, in which the same motion may occur again.
        kind: whether to look at what the effort holds, which takes half a second.

    Raises:
        ModelError: a recording lacks a joint of the model.
    """
    case = Case.of(model, motion, others)
    found = [check for look in CHECKS for check in look(case)]
    if kind:
        said = {(check.check, check.joint) for check in found if check.serious}
        more = effort_checks(model, case.motion)
        found += [one for one in more if (one.check, one.joint) not in said]
    return sorted(found, key=lambda check: not check.serious)


def effort_checks(model: Model, motion: Motion) -> list[Check]:
    """Return what a motion's torques show of what its effort holds and, with a URDF, of its unit.

    Args:
        model: says which joints slide, and the masses of a URDF; its torques are not used.
        motion: of the model's joints.
    """
    sliding = np.flatnonzero(sliding_of(model.kernel, len(model.joints)))
    found, robot = kind_checks(motion, sliding.tolist()), model.kernel.mechanism
    return [*found, *urdf_unit_checks(motion, robot)] if isinstance(robot, Robot) else found
