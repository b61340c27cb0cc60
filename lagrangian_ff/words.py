"""Lists of names as people say them."""

from collections.abc import Mapping, Sequence
from typing import Any

MANY = 3
"""From so many joints on, all of them are `every joint`."""


def listed(names: Sequence[str]) -> str:
    """a, b and c."""
    return ", ".join(names[:-1]) + (" and " if len(names) > 1 else "") + "".join(names[-1:])


def which(joints: Sequence[str], every: Sequence[str]) -> str:
    """Some joints of an arm by name, or what is shorter: all of them, or all but one.

    Args:
        joints: that are meant.
        every: all joints of the arm.
    """
    others = [joint for joint in every if joint not in joints]
    if len(every) < MANY or len(joints) < len(every) - 1:
        return ", ".join(joints)
    return f"every joint but {others[0]}" if others else "every joint"


def where(found: Mapping[str, Any], every: Sequence[str] = ()) -> str:
    """Where a finding acts, and whose gear it is where that is another joint's.

    Args:
        found: a record with `joints`, and `caused_by` where it is known.
        every: all joints of the arm.
    """
    said = which(found["joints"], every)
    cause = found.get("caused_by")
    return f"{said} (gear of {cause})" if cause and cause not in found["joints"] else said
