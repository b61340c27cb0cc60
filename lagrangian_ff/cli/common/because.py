"""The finding of a diagnosis for which an effect is added."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lagrangian_ff.errors import UserError
from lagrangian_ff.record_json import why_of

NEEDED = {"effect", "joints", "shape", "why", "verdict", "evidence_gain", "p_value"}
"""What is read of a finding."""


@dataclass(frozen=True)
class Because:
    """What a diagnosis says of an effect on a joint.

    Attributes:
        why: for the model's history.
        shape: what it says of what the effect is not linear in.
    """

    why: Mapping[str, object]
    shape: Mapping[str, float]


def found_in(path: Path, effect: str, joint: str) -> Because:
    """The finding of an effect on a joint.

    Args:
        path: what `diagnose --json` wrote.
        effect, joint: what is to be added.

    Raises:
        UserError: there is no such file, it is no diagnosis, or it found no such effect to add.
    """
    findings = _findings(path)
    for one in findings:
        if one["effect"] == effect and joint in one["joints"] and one["why"]:
            return Because(why_of(one), one["shape"])
    others = [f"{one['effect']} on {one['joints'][0]}" for one in findings if one["why"]]
    raise UserError(
        f"--because {path}: it does not find {effect} on {joint}; it finds "
        f"{', '.join(others) or 'nothing to add'}"
    )


def _findings(path: Path) -> list[dict[str, Any]]:
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UserError(f"--because {path}: {error.strerror or error}") from None
    except ValueError:
        record = None
    findings = record.get("findings") if isinstance(record, dict) else None
    if not isinstance(findings, list) or not all(
        isinstance(one, dict) and one.keys() >= NEEDED for one in findings
    ):
        raise UserError(
            f"--because {path}: expected the file that lagrangian_ff diagnose --json writes"
        )
    return findings
