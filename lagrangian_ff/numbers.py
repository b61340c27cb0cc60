"""Numbers as people read them: plain in a terminal, typeset in pages and figures."""

import math

DASH = "–"
"""Stands in pages for a number that is not known."""
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float | None, digits: int = 3) -> str:
    """Return a number with this many significant digits, without an exponent if possible.

    An unknown number, and one that is not finite, is `-`.
    """
    if value is None or not math.isfinite(value):
        return "-"
    if value == 0.0:
        return "0"
    rounded = f"{value:.{digits - 1}e}"
    exponent = int(rounded.partition("e")[2])
    if exponent < -4 or exponent > 5:
        return rounded
    return f"{value:.{max(0, digits - 1 - exponent)}f}"


def typeset(value: float | None, digits: int = 3) -> str:
    """Return `number` with a real minus and powers of ten; an unknown number is a dash."""
    if value is None or not math.isfinite(value):
        return DASH
    mantissa, _, exponent = number(value, digits).partition("e")
    power = f"·10{str(int(exponent)).translate(_SUPERSCRIPTS)}" if exponent else ""
    return f"{mantissa.replace('-', '−')}{power}"


def percent(share: float) -> str:
    """Return a share in percent, with one more digit below 10 %; an unknown share is a dash."""
    if not math.isfinite(share):
        return DASH
    return f"{100.0 * share:.{1 if abs(share) < 0.0995 else 0}f} %"


def mrad(angle: float) -> str:
    """Return an angle in rad as mrad, without the unit."""
    return f"{1e3 * angle:.2f}" if abs(angle) < 0.01 else f"{1e3 * angle:.1f}"


def chance(p: float | None, unknown: str = "-") -> str:
    """Return a probability; a finite number of draws cannot show that one is zero."""
    if p is None or not math.isfinite(p):
        return unknown
    return f"{p:.2g}" if p >= 0.001 else "< 0.001"
