"""Names, sentences and findings as people say them."""

from collections.abc import Mapping, Sequence
from typing import Any

PLAIN = ("confirmed", "suggested")
"""Verdicts that name no other effect."""
MANY = 3
"""An arm with fewer joints than this has them all named; else they are `every joint`."""


def listed(names: Sequence[str]) -> str:
    """Return `a, b and c`."""
    return ", ".join(names[:-1]) + (" and " if len(names) > 1 else "") + "".join(names[-1:])


def which(joints: Sequence[str], every: Sequence[str]) -> str:
    """Return some joints of an arm by name or, if that is shorter, as all of them or all but one.

    Args:
        joints: the joints to name.
        every: all joints of the arm.
    """
    others = [joint for joint in every if joint not in joints]
    if len(every) < MANY or len(joints) < len(every) - 1:
        return ", ".join(joints)
    return f"every joint but {others[0]}" if others else "every joint"


def where(found: Mapping[str, Any], every: Sequence[str] = ()) -> str:
    """Return where a finding acts, and in whose gear if that is another joint's.

    Args:
        found: its record, with `joints`, and `caused_by` if that is known.
        every: all joints of the arm.
    """
    said = which(found["joints"], every)
    cause = found.get("caused_by")
    return f"{said} (gear of {cause})" if cause and cause not in found["joints"] else said


def standing(found: Mapping[str, Any]) -> str:
    """Return the verdict on a finding in one word: confirmed, suggested or ambiguous."""
    verdict = str(found["verdict"])
    return "ambiguous" if found.get("ambiguous_with") and verdict not in PLAIN else verdict


def spoken(name: str) -> str:
    """Return an effect's name as words; the joint after `on` keeps its name."""
    effect, on, joint = name.partition(" on ")
    return f"{effect.replace('_', ' ')}{on}{joint}"


def sentence(text: str) -> str:
    """Return a text with a capital letter and a full stop."""
    text = text.strip()
    word = text.split(" ", 1)[0]
    first = text[:1].upper() if word.isalpha() else text[:1]  # joint_2 stays as it is
    return f"{first}{text[1:]}{'' if text.endswith(('.', '!', '?')) else '.'}"


def counted(number: int, thing: str) -> str:
    """Return `1 gap`, `2 gaps`."""
    return f"{number} {thing}" if number == 1 else f"{number} {thing}s"
