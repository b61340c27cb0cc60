"""Whether a recording holds what identification needs, said in full where it does not."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording.recording import Recording

Floats = NDArray[np.float64]

_EFFORT_HINT = (
    "the driver must offer an effort state interface and joint_state_broadcaster must publish it"
)
_LEAVE_OUT = "or leave the joint out by naming the others as joints"


def require_usable(recording: Recording) -> None:
    """Position and effort on every joint.

    Raises:
        RecordingError: naming file, topic, joints and time.
    """
    source = recording.source
    if len(recording) < 2 or not recording.joints:
        raise RecordingError(
            f"{source}: {len(recording)} samples of {len(recording.joints)} joints; "
            "expected a recording of an arm that moves"
        )
    timeless = ~np.isfinite(recording.time)
    if timeless.any():
        raise RecordingError(
            f"{source}: time is not a number in {int(timeless.sum())} samples, first in sample "
            f"{int(np.argmax(timeless)) + 1} of {len(timeless)}"
        )
    lost = _where(recording, ~np.isfinite(recording.position).any(axis=0))
    if lost:
        raise RecordingError(
            f"{source}: no position of {', '.join(lost)}: NaN in all {len(recording)} samples "
            f"{_when(recording)}; check the joint's driver, {_LEAVE_OUT}"
        )
    known = np.isfinite(recording.effort)
    silent = _where(recording, ~known.any(axis=0))
    if silent:
        who = "any joint" if len(silent) == len(recording.joints) else ", ".join(silent)
        raise RecordingError(
            f"{source}: no effort of {who}: empty or NaN in all {len(recording)} samples "
            f"{_when(recording)}; {_EFFORT_HINT}"
            + ("" if len(silent) == len(recording.joints) else f", {_LEAVE_OUT}")
        )
    zero = _where(recording, ~((recording.effort != 0) & known).any(axis=0))
    if zero:
        who = "every joint" if len(zero) == len(recording.joints) else ", ".join(zero)
        raise RecordingError(
            f"{source}: the effort of {who} is 0 in all {len(recording)} samples "
            f"{_when(recording)}; {_EFFORT_HINT}, not fill it with zeros"
            + ("" if len(zero) == len(recording.joints) else f", {_LEAVE_OUT}")
        )


def require_known(recording: Recording, named: Mapping[str, Mapping[str, float]]) -> None:
    """Settings given by joint, by the name of the setting, must be for joints there are.

    Raises:
        RecordingError: naming the setting and the joint.
    """
    for setting, values in named.items():
        unknown = [joint for joint in values if joint not in recording.joints]
        if unknown:
            raise RecordingError(
                f"{recording.source}: {setting} is given for {', '.join(unknown)}, but the "
                f"recording holds {', '.join(recording.joints)}"
            )


def _where(recording: Recording, chosen: "NDArray[np.bool_] | np.bool_") -> list[str]:
    return [
        joint for joint, is_so in zip(recording.joints, np.atleast_1d(chosen), strict=True) if is_so
    ]


def _when(recording: Recording) -> str:
    return f"from {recording.time.min():.3f} s to {recording.time.max():.3f} s"
