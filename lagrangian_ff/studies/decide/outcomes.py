"""The outcome of each arm of the study, read from its line of `cases.jsonl`."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lagrangian_ff.investigation import Ended
from lagrangian_ff.investigation.motions import SHORTEST
from lagrangian_ff.studies.decide.cases import BUDGET
from lagrangian_ff.studies.hidden.verdicts import Judgement, Outcome
from lagrangian_ff.studies.study import Line

LARGE_ENOUGH = 0.5
"""Share of the size that was asked for, below which an arm does not count."""


@dataclass(frozen=True)
class Opened:
    """A case that the usual motion left open, and what two motions made of it.

    Attributes:
        case: its name.
        designed, template: judgements; None if the motion could not be done.
        nats: log Bayes factors of the true effect with the designed motion and the template.
        expected: nats of the designed motion alone, before it was done.
        visible: rms of the effect's torque that plain friction cannot imitate, over the torque that
            the diagnosis leaves unexplained on the joint.
        attainable: nats that the effect's true torque gains on the designed motion beside all that
            was confirmed.
    """

    case: str
    designed: Judgement | None
    template: Judgement | None
    nats: tuple[float, float] | None
    expected: float
    visible: float | None = None
    attainable: float | None = None

    @classmethod
    def of(cls, line: Line) -> "Opened":
        """Return the case of a line of the group `motion`."""
        both = [line[name] for name in ("designed", "template")]
        judged = [Judgement.of(one["judgement"]) if "nats" in one else None for one in both]
        nats = None
        if all("nats" in one for one in both):
            nats = (float(both[0]["nats"]), float(both[1]["nats"]))
        return cls(
            line["case"],
            judged[0],
            judged[1],
            nats,
            float(line["expected"]),
            both[0].get("visible"),
            both[0].get("attainable"),
        )


@dataclass(frozen=True)
class Investigated:
    """An arm that was investigated.

    Attributes:
        case, group: of the line.
        judgement: of what was confirmed in the end.
        moved: s of motion.  when: s after which the truth was named for good; None for never.
        early: whether it ended since nothing was left to decide, and time for a motion was left.
        left: samples in which a motion left its limits or the motors saturated.
        error: N·m rms before and after; the latter None without a turn.
        promised: nats that 30 s more would give, designed for what stayed hidden; None for nothing.
        visible: rms of the effect's torque that plain friction cannot imitate, over the torque that
            the last diagnosis leaves unexplained on the joint; None if the arm hides nothing.
        attainable: nats that the true torque of an effect that stayed hidden gains beside all that
            was confirmed; None for nothing.
    """

    case: str
    group: str
    judgement: Judgement
    moved: float
    when: float | None
    early: bool
    left: int
    error: tuple[float, float | None]
    promised: float | None = None
    visible: float | None = None
    attainable: float | None = None

    @classmethod
    def of(cls, line: Line) -> "Investigated":
        """Return the arm of a line of the groups `five`, `two` and `clean`."""
        before, after = line["error"]
        return cls(
            line["case"],
            line["group"],
            Judgement.of(line["judgement"]),
            line["moved"],
            line["when"],
            line["story"]["ended"] == Ended.NOTHING_LEFT.value
            and line["moved"] <= BUDGET - SHORTEST,
            line["left"],
            (before, after),
            line.get("promised"),
            line.get("visible"),
            line.get("attainable"),
        )


@dataclass(frozen=True)
class Taken:
    """Physics outside the catalogue.

    Attributes:
        case: its name.  over: the coordinates of the curve.
        curve, formula: error on unseen motion with the curve, and with the formula proposed first,
            over that with the true structure; `formula` is None without a proposal.
        rank: of the true form among the formulas, from 1; 0 if it is not there.
    """

    case: str
    over: Sequence[str]
    curve: float
    formula: float | None
    rank: int

    @classmethod
    def of(cls, line: Line) -> "Taken":
        """Return the case of a line of the group `outside`."""
        errors = [line[name] for name in ("curve", "formula", "true")]
        curve, formula, true = (np.nan if one is None else float(one) for one in errors)
        found = formula / true if np.isfinite(formula) else None
        return cls(line["case"], tuple(line["over"]), curve / true, found, line["rank"])


def is_too_small(line: Line) -> bool:
    """Return whether an arm cannot have its effect half as large as was asked for.

    A gear that twists or plays as far as gears do may give a slow arm less torque than that.
    """
    wanted = line.get("hidden")
    return wanted is not None and line.get("size", wanted[2]) < LARGE_ENOUGH * wanted[2]


def is_open(line: Line) -> bool:
    """Return whether the usual motion left a line of the group `motion` open."""
    return Judgement.of(line["before"]).outcome is not Outcome.RIGHT
