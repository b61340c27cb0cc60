"""Numbers and tables as text."""

import math
from collections.abc import Sequence


def number(value: float | None, digits: int = 3) -> str:
    """A number with this many significant digits, without an exponent where one can do so."""
    if value is None or not math.isfinite(value):
        return "-"
    if value == 0.0:
        return "0"
    exponent = math.floor(math.log10(abs(value)))
    if exponent < -4 or exponent > 5:
        return f"{value:.{digits - 1}e}"
    return f"{value:.{max(0, digits - 1 - exponent)}f}"


def table(header: Sequence[str], rows: Sequence[Sequence[str]], indent: str = "  ") -> list[str]:
    """Columns two spaces apart; those that hold numbers from the second on to the right."""
    columns = list(zip(header, *rows, strict=True))
    widths = [max(map(len, column)) for column in columns]
    right = [_numeric(column[1:]) for column in columns]
    lines = []
    for row in [header, *rows]:
        cells = [
            cell.rjust(width) if to_right else cell.ljust(width)
            for cell, width, to_right in zip(row, widths, right, strict=True)
        ]
        lines.append((indent + "  ".join(cells)).rstrip())
    return lines


def _numeric(cells: Sequence[str]) -> bool:
    return all(cell == "-" or cell.lstrip("-")[:1].isdigit() for cell in cells) and bool(cells)
