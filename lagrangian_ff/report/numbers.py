"""Numbers as people read them."""

import math


def number(value: float, digits: int = 3) -> str:
    """Three significant digits, without an exponent where that can be read."""
    if not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    if value < 0.0:
        return f"−{number(-value, digits)}"
    size = math.floor(math.log10(value))
    if size < -4 or size > 5:
        mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
        return f"{mantissa}·10{_superscript(int(exponent))}"
    return f"{value:.{max(0, digits - 1 - size)}f}"


def percent(share: float) -> str:
    """A share in percent, finer where it is small."""
    if not math.isfinite(share):
        return "–"
    return f"{100.0 * share:.{1 if abs(share) < 0.0995 else 0}f} %"


def mrad(angle: float) -> str:
    """An angle in rad as mrad, without the unit."""
    return f"{1e3 * angle:.2f}" if abs(angle) < 0.01 else f"{1e3 * angle:.1f}"


def _superscript(value: int) -> str:
    return str(value).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
