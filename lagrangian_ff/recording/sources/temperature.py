"""Temperatures of joints: `sensor_msgs/msg/Temperature` beside the joint states of a bag.

A topic is of the joint that its name holds, or else the frame_id of its messages.
"""

import math
import re
import struct
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from lagrangian_ff import budget
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.words import counted

MESSAGE_TYPE = "sensor_msgs/msg/Temperature"
_HEADER = 4  # the encapsulation header; alignment counts from behind it


def with_temperatures(
    recording: Recording, messages: Iterable[tuple[str, int, bytes]]
) -> Recording:
    """Return a recording with its joints' temperatures, and notes on which topics they are from.

    Args:
        recording: of the joint states.
        messages: topic, time received in ns, and serialized message, in order of arrival.
    """
    notes = list(recording.notes)
    found: dict[tuple[str, str], list[tuple[float, float]]] = {}
    malformed = 0
    for topic, received, data in messages:
        read = parsed(data)
        if read is None or not math.isfinite(read[2]):
            malformed += 1
            continue
        stamp, frame, value = read
        if (topic, frame) not in found and len(found) >= budget.JOINTS:
            malformed += 1
            continue
        time = (stamp or received) / 1e9 - recording.start
        found.setdefault((topic, frame), []).append((time, value))
    if malformed:
        notes.append(f"left out {counted(malformed, 'temperature')} malformed or not a number")
    temperature = np.full(recording.position.shape, np.nan)
    used: dict[str, str] = {}
    for (topic, frame), pairs in found.items():
        where = f"temperature on {topic}" + (f" (frame_id {frame})" if frame else "")
        joint = joint_of(topic, recording.joints) or joint_of(frame, recording.joints)
        time, values = np.array(sorted(pairs)).T
        if joint is None:
            reason = f"names none or several of the joints {', '.join(recording.joints)}"
        elif joint in used:
            reason = f"is of {joint} too, whose temperature is that on {used[joint]}"
        elif time[-1] < recording.time.min() or time[0] > recording.time.max():
            away = max(recording.time.min() - time[-1], time[0] - recording.time.max())
            reason = f"has stamps {away:.3g} s away from those of the joint states"
        else:
            used[joint] = topic
            column = recording.joints.index(joint)
            temperature[:, column] = np.interp(recording.time, time, values)
            notes.append(f"{where} is that of {joint}: {counted(len(values), 'message')}")
            continue
        notes.append(f"{where} {reason}: not used")
    return replace(recording, notes=tuple(notes), temperature=temperature if used else None)


def joint_of(text: str, joints: Sequence[str]) -> str | None:
    """Return the joint whose name a text holds as a word; None if it is none or several."""
    named = [
        joint for joint in joints if re.search(rf"(?<![^\W_]){re.escape(joint)}(?![^\W_])", text)
    ]
    longest = [one for one in named if not any(one != other and one in other for other in named)]
    return longest[0] if len(longest) == 1 else None


def parsed(data: bytes) -> tuple[int, str, float] | None:
    """Return stamp in ns, frame_id and °C of a message in CDR; None if it is malformed."""
    try:
        order = "<" if data[1] & 1 else ">"
        seconds, nanoseconds, length = struct.unpack_from(f"{order}iII", data, _HEADER)
        frame = data[_HEADER + 12 : _HEADER + 12 + length].rstrip(b"\0")
        at = _HEADER + 8 * -(-(12 + length) // 8)
        (value,) = struct.unpack_from(f"{order}d", data, at)
        return seconds * 10**9 + nanoseconds, frame.decode(errors="replace"), value
    except (struct.error, IndexError):
        return None
