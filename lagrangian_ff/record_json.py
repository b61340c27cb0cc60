"""Records as JSON, the same from the command line and from the nodes."""

import json
import math
from collections.abc import Mapping
from typing import Any


def to_json(record: Mapping[str, object]) -> str:
    """Return a record as text; numbers that are not finite become null."""
    return json.dumps(finite(record), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def why_of(finding: Mapping[str, Any]) -> dict[str, object]:
    """Return what the history of a model keeps of the finding for which an effect was added."""
    return {name: finding[name] for name in ("why", "verdict", "evidence_gain", "p_value")}


def finite(value: Any) -> Any:
    """Return the value as dicts, lists and scalars; numbers that are not finite are None."""
    if isinstance(value, Mapping):
        return {str(key): finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [finite(inner) for inner in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
