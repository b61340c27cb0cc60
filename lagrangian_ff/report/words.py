"""Names and findings as people say them."""

import math


def spoken(name: str) -> str:
    """An effect's name as words; the joint after `on` keeps its own."""
    effect, on, joint = name.partition(" on ")
    return f"{effect.replace('_', ' ')}{on}{joint}"


def sentence(text: str) -> str:
    """With a capital letter and a full stop."""
    text = text.strip()
    word = text.split(" ", 1)[0]
    first = text[:1].upper() if word.isalpha() else text[:1]  # joint_2 stays as it is
    return f"{first}{text[1:]}{'' if text.endswith(('.', '!', '?')) else '.'}"


def chance(p: float | None) -> str:
    """A probability, which a finite number of trials cannot tell to be zero."""
    if p is None or not math.isfinite(p):
        return "–"
    return f"{p:.2g}" if p >= 0.001 else "< 0.001"
