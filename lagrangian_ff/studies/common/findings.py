"""What a study set out to see: whether it holds, and the figures that say so."""

from collections.abc import Mapping
from typing import Any

Finding = dict[str, Any]
"""`holds`, `says` in a sentence, and the figures of that sentence by name, as JSON holds them."""


def finding(holds: bool, says: str, **figures: Any) -> Finding:
    """One finding."""
    return {"holds": bool(holds), "says": says, **figures}


def told(findings: Mapping[str, Finding]) -> list[str]:
    """Findings as lines of text, after an empty one; nothing where there are none."""
    if not findings:
        return []
    return [
        "",
        *(f"{'yes' if each['holds'] else 'NO':<4} {each['says']}" for each in findings.values()),
    ]
