"""Records as JSON, the same from the command line and from the nodes."""

import json
import math
from collections.abc import Mapping
from typing import Any


def to_json(record: Mapping[str, object]) -> str:
    """A record as text; numbers that are not finite become null, as JSON has no word for them."""
    return json.dumps(_finite(record), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def why_of(finding: Mapping[str, Any]) -> dict[str, object]:
    """What the history of a model tells of a finding of a diagnosis, for which it was enlarged."""
    return {name: finding[name] for name in ("why", "verdict", "evidence_gain", "p_value")}


def _finite(value: object) -> object:
    if isinstance(value, Mapping):
        return {str(key): _finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(inner) for inner in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
