"""Names and sentences as people say them."""

import math
from collections.abc import Sequence

GRADES = ((0.01, "very good"), (0.05, "good"), (0.2, "fair"), (0.5, "poor"))
"""The nmse up to which each word holds; above the last it is `bad`."""
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


def grade(nmse: float | None) -> str:
    """Return an nmse as a word."""
    if nmse is None or not math.isfinite(nmse):
        return "not judged: its torque did not vary"
    return next((word for limit, word in GRADES if nmse <= limit), "bad")


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
