"""A design as JSON, and what came of it: the gains expected beside those that a diagnosis found."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.excite.assumed import Expected
from lagrangian_ff.diagnosis.excite.design import Design
from lagrangian_ff.diagnosis.excite.questions import Between, For, Parameters, Question

Record = dict[str, Any]


def words_of(question: Question) -> str:
    """Return a question in words."""
    if isinstance(question, For):
        return f"is {question.suspect} there?"
    if isinstance(question, Between):
        return f"is it {question.first} or {question.second}?"
    if isinstance(question, Parameters):
        return "which masses and inertias does the arm have?"
    return "what is there of all that the model's own data do not show?"


def design_record(design: Design) -> Record:
    """Return a design as JSON holds it, without the motion itself."""
    expected = sorted(design.expected, key=lambda one: -one.nats)
    return {
        "question": words_of(design.question),
        "seconds": float(design.reference.time[-1]),
        "nats": design.nats,
        "begun_from": design.begun,
        "finished": design.finished,
        "beyond_seen": list(design.beyond),
        "expected": [asdict(one) for one in expected],
        "not_shown": [
            {"effect": one.effect, "joint": one.joint}
            for one in expected
            if one.nats < thresholds.USED.floor
        ],
        "used": {
            name: dict(zip(design.joints, share.tolist(), strict=True))
            for name, share in design.used.items()
        },
    }


@dataclass(frozen=True)
class Outcome:
    """An effect that a diagnosis found, beside what the design of its motion had promised.

    Attributes:
        effect, joint: their names.
        ratio: of the torque found to that of the size that the promise was for.
        promised: nats for an effect as large as the one found.
        gained: nats that the diagnosis found.
    """

    effect: str
    joint: str
    ratio: float
    promised: float
    gained: float


def outcomes(design: Mapping[str, Any], diagnosis: Mapping[str, Any]) -> tuple[Outcome, ...]:
    """Return what came of a design, from its JSON and that of a diagnosis of its recording.

    Raises:
        ValueError: one of the two is no such JSON.
    """
    try:
        every = [Expected(**one) for one in design["expected"]]
        promised = {(one.effect, one.joint): one for one in every}
        found = []
        for one in diagnosis["findings"]:
            key = str(one["effect"]), str(one["joints"][0])
            if key in promised and "size" in one:
                mine, torque = promised[key], float(one["size"])
                share = torque / mine.torque if mine.torque > 0.0 else 0.0
                gained = float(one["evidence_gain"])
                found.append(Outcome(*key, share, mine.of_torque(torque), gained))
    except (KeyError, TypeError, IndexError, ValueError) as error:
        raise ValueError(f"not the JSON of a design and of a diagnosis: {error!r}") from None
    return tuple(found)
