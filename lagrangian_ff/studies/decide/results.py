"""What the arms of the study say, counted: numbers, targets, table and figure."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.record_json import finite
from lagrangian_ff.report.colours import AFTER, BEFORE, GOOD, INK
from lagrangian_ff.report.style import new_figure, styled
from lagrangian_ff.studies.decide.sooner import ratio
from lagrangian_ff.studies.hidden.verdicts import Judgement, Outcome
from lagrangian_ff.studies.study import Finding, Line, Results, done, row, shown

NAMED, WRONG = 0.9, 0.02
"""Share of open cases that a designed motion names at least, and of wrong names at most."""
RATIO = 3.0
"""Least median ratio of the nats of a designed motion and of its template, at equal time."""
FOUND = {"five": 0.9, "two": 0.8}
"""Least share of effects that an investigation finds, by group."""
WORDS = {"five": "5 %", "two": "2 %", "clean": "nothing"}
CURVE, FIRST = 1.15, 0.6
"""Largest ratio of the unseen error with a curve to that of the true structure, and the least share
of true forms among the first three formulas."""
SOONER = 0.6
"""Largest share of the time of `exciting` after which a designed motion has its error."""
FEWEST = 5
"""Cases from which on a share is a finding."""
EARLY = 240.0


@dataclass(frozen=True)
class Opened:
    """A case that the usual motion left open, and what two motions made of it.

    Attributes:
        case: its name.
        designed, template: judgements; None if the motion could not be done.
        nats: log Bayes factors of the true effect with the designed motion and the template.
        expected: nats of the designed motion alone, before it was done.
    """

    case: str
    designed: Judgement | None
    template: Judgement | None
    nats: tuple[float, float] | None
    expected: float

    @classmethod
    def of(cls, line: Line) -> "Opened":
        """Return the case of a line of the group `motion`."""
        both = [line[name] for name in ("designed", "template")]
        judged = [Judgement.of(one["judgement"]) if "nats" in one else None for one in both]
        nats = None
        if all("nats" in one for one in both):
            nats = (float(both[0]["nats"]), float(both[1]["nats"]))
        return cls(line["case"], judged[0], judged[1], nats, float(line["expected"]))


@dataclass(frozen=True)
class Investigated:
    """An arm that was investigated.

    Attributes:
        case, group: of the line.
        judgement: of what was confirmed in the end.
        moved: s of motion.  when: s after which the truth was named for good; None for never.
        left: samples in which a motion left its limits or the motors saturated.
        error: N·m rms before and after; the latter None without a turn.
        promised: nats that 30 s more would give, designed for what stayed hidden; None for nothing.
    """

    case: str
    group: str
    judgement: Judgement
    moved: float
    when: float | None
    left: int
    error: tuple[float, float | None]
    promised: float | None = None


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


def _is_open(line: Line) -> bool:
    return Judgement.of(line["before"]).outcome is not Outcome.RIGHT


@dataclass(frozen=True)
class DecideResults(Results):
    """The results of the study.

    Attributes:
        opened: cases of designed motions that the usual motion left open.
        decided: the number of those that it did not.
        investigated: by group.
        taken: physics outside the catalogue.
        sooner: by case, the time of designed motion over that of `exciting` for one error;
            infinite where it is never reached.
    """

    opened: Sequence[Opened]
    decided: int
    investigated: Mapping[str, Sequence[Investigated]]
    taken: Sequence[Taken]
    sooner: Mapping[str, float]

    @classmethod
    def of(cls, lines: Sequence[Line]) -> "DecideResults":
        """Return the results of all or some of the lines."""
        sound = done(lines)
        motion = [line for line in sound if line["group"] == "motion"]
        opened = [Opened.of(line) for line in motion if _is_open(line)]
        groups: dict[str, list[Investigated]] = {group: [] for group in WORDS}
        for line in sound:
            if line["group"] in groups:
                groups[line["group"]].append(
                    Investigated(
                        line["case"],
                        line["group"],
                        Judgement.of(line["judgement"]),
                        line["moved"],
                        line["when"],
                        line["left"],
                        (line["error"][0], line["error"][1]),
                        line.get("promised"),
                    )
                )
        taken = [Taken.of(line) for line in sound if line["group"] == "outside"]
        early = {line["case"]: ratio(line) for line in sound if line["group"] == "sooner"}
        found = shown({
            **_of_motions(opened),
            **_of_investigations(groups),
            **_of_unlisted(taken),
            **_of_time(list(early.values())),
        })  # fmt: skip
        decided = len(motion) - len(opened)
        return cls(lines, found, opened, decided, groups, taken, early)

    def numbers(self) -> dict[str, Any]:
        return {
            "decided by the usual motion": self.decided,
            "open": [
                {
                    "case": one.case,
                    "designed": one.designed.record() if one.designed else None,
                    "template": one.template.record() if one.template else None,
                    "nats": one.nats,
                    "expected": one.expected,
                }
                for one in self.opened
            ],
            "investigated": {
                group: [
                    {
                        "case": one.case,
                        "outcome": one.judgement.outcome.value,
                        "false": list(one.judgement.false),
                        "moved": one.moved,
                        "when": one.when,
                        "left": one.left,
                        "error": one.error,
                        "promised": one.promised,
                    }
                    for one in some
                ]
                for group, some in self.investigated.items()
            },
            "outside": [asdict(one) for one in self.taken],
            "sooner": {name: finite(one) for name, one in self.sooner.items()},
        }

    def text(self) -> list[str]:
        lines = [
            f"open after {30:g} s of usual motion: {len(self.opened)} "
            f"(decided by it: {self.decided})",
            row("after 30 s more", ["named", "class", "wrong", "nothing", "nats"], 20),
        ]
        for name, judged in (
            ("the designed one", [one.designed for one in self.opened]),
            ("the template's", [one.template for one in self.opened]),
        ):
            place = 0 if name == "the designed one" else 1
            nats = [one.nats[place] for one in self.opened if one.nats]
            middle = f"{np.median(nats):.0f}" if nats else "-"
            lines.append(row(name, [*_counted(judged), middle], 20))
        lines += ["", row("investigated", ["arms", "named", "class", "wrong", "moved [s]"], 20)]
        for group, some in self.investigated.items():
            named, alike, wrong, _ = _counted([one.judgement for one in some])
            moved = f"{np.median([one.moved for one in some]):.0f}" if some else "-"
            lines.append(row(WORDS[group], [str(len(some)), named, alike, wrong, moved], 20))
        if self.taken:
            lines += ["", row("outside the catalogue", ["curve", "formula", "rank"], 26)]
            for one in self.taken:
                formula = "-" if one.formula is None else f"{one.formula:.2f}"
                name = one.case.removeprefix("outside-").replace("_", " ")
                lines.append(row(name, [f"{one.curve:.2f}", formula, str(one.rank or "-")], 26))
        if self.sooner:
            lines += ["", "time until one error, designed over exciting: " + ", ".join(
                f"{one:.2f}" for one in sorted(self.sooner.values()))]  # fmt: skip
        return lines

    def figure(self) -> Figure:
        with styled():
            figure = new_figure(3.4)
            left, right = figure.subplots(1, 2)
            nats = np.array([one.nats for one in self.opened if one.nats]).reshape(-1, 2)
            least = 1.0
            left.loglog(np.maximum(nats[:, 1], least), np.maximum(nats[:, 0], least), "o",
                        color=AFTER, alpha=0.7)  # fmt: skip
            ends = np.array([least, max(10.0, float(nats.max(initial=10.0)))])
            left.loglog(ends, ends, color=BEFORE)
            left.loglog(ends, RATIO * ends, color=BEFORE, linestyle="--")
            left.set_xlabel("nats with the template's motion")
            left.set_ylabel("with the designed one")
            left.set_title("the true effect's log Bayes factor, equal time")
            colours = {"five": GOOD, "two": AFTER, "clean": INK}
            for group, some in self.investigated.items():
                when = sorted(one.when for one in some if one.when is not None)
                if some and group != "clean":
                    share = np.arange(1, len(when) + 1) / len(some)
                    right.step([0.0, *when, EARLY], [0.0, *share, share[-1] if when else 0.0],
                               where="post", color=colours[group], label=WORDS[group])  # fmt: skip
            right.set_ylim(0.0, 1.05)
            right.set_xlabel("s of motion")
            right.set_ylabel("share found and added")
            right.set_title("investigations")
            right.legend()
        return figure


def _counted(judged: Sequence[Judgement | None]) -> list[str]:
    outcomes = [one.outcome for one in judged if one is not None]
    wrong = sum(bool(one.false) for one in judged if one is not None)
    return [
        str(outcomes.count(Outcome.RIGHT)),
        str(outcomes.count(Outcome.CLASS)),
        str(wrong),
        str(outcomes.count(Outcome.NOTHING)),
    ]


def _of_motions(opened: Sequence[Opened]) -> dict[str, Finding | None]:
    found: dict[str, Finding | None] = {}
    if len(opened) >= FEWEST:
        judged = [one.designed for one in opened if one.designed]
        named = sum(one.outcome is Outcome.RIGHT for one in judged) / len(opened)
        wrong = sum(bool(one.false) for one in judged) / len(opened)
        found["designed"] = Finding(
            named >= NAMED and wrong <= WRONG,
            f"one designed motion names {named:.2f} of what the usual one leaves open, "
            f"{wrong:.2f} wrongly (wanted {NAMED:g} and {WRONG:g})",
            {"named": named, "wrong": wrong},
        )
        sure = [one for one in opened if one.expected >= thresholds.USED.floor]
        decided = sum(
            one.designed is not None and one.designed.outcome is Outcome.RIGHT for one in sure
        )
        found["promised"] = Finding(
            decided >= NAMED * len(sure),
            f"{len(sure)} of {len(opened)} designs promise {thresholds.USED.floor:g} nats or more; "
            f"{decided} of these are named",
            {"promised": len(sure), "named": decided},
        )
        ratios = [max(a, 1.0) / max(b, 1.0) for one in opened if one.nats for a, b in [one.nats]]
        middle = float(np.median(ratios)) if ratios else 0.0
        found["ratio"] = Finding(
            middle >= RATIO,
            f"at equal time it has {middle:.1f} times the nats of the template, in the median "
            f"(wanted {RATIO:g})",
            {"median": middle},
        )
    return found


def _of_investigations(groups: Mapping[str, Sequence[Investigated]]) -> dict[str, Finding | None]:
    found: dict[str, Finding | None] = {}
    for group, wanted in FOUND.items():
        some = groups[group]
        if len(some) >= FEWEST:
            share = sum(one.judgement.outcome is Outcome.RIGHT for one in some) / len(some)
            hidden = [one for one in some if one.judgement.outcome is not Outcome.RIGHT]
            little = sum((one.promised or 0.0) < thresholds.USED.floor for one in hidden)
            found[group] = Finding(
                share >= wanted,
                f"investigations find and add {share:.2f} of effects of {WORDS[group]} "
                f"(wanted {wanted:g}); of the {len(hidden)} others, 30 s designed for the effect "
                f"promise less than {thresholds.USED.floor:g} nats for {little}",
                {"share": share, "hidden": len(hidden), "too little": little},
            )
    if len(groups["clean"]) >= FEWEST:
        wrong_names = sum(bool(one.judgement.false) for one in groups["clean"])
        early = sum(one.moved < EARLY for one in groups["clean"])
        found["clean"] = Finding(
            wrong_names == 0 and early == len(groups["clean"]),
            f"of {len(groups['clean'])} clean arms {wrong_names} have a name, {early} ended early",
            {"wrong": wrong_names, "early": early},
        )
    every = [one for some in groups.values() for one in some]
    if len(every) >= FEWEST:
        left = sum(one.left for one in every)
        found["limits"] = Finding(
            left == 0, f"limits were left in {left} samples of {len(every)} arms", {"left": left}
        )
    return found


def _of_unlisted(taken: Sequence[Taken]) -> dict[str, Finding | None]:
    if len(taken) < FEWEST:
        return {}
    largest = max(one.curve for one in taken)
    within = sum(min(one.curve, one.formula or np.inf) <= CURVE for one in taken)
    named = sum(0 < one.rank <= 3 for one in taken) / len(taken)
    return {
        "curve": Finding(
            within == len(taken),
            f"a curve or a formula has at most {CURVE:g} times the unseen error of the truth in "
            f"{within} of {len(taken)} cases (a curve at most {largest:.2f} times)",
            {"within": within, "cases": len(taken), "largest": largest},
        ),
        "formula": Finding(
            named >= FIRST,
            f"the true form is among the first three formulas in {named:.2f} of cases "
            f"(wanted {FIRST:g})",
            {"share": named},
        ),
    }


def _of_time(ratios: Sequence[float]) -> dict[str, Finding | None]:
    if len(ratios) < FEWEST:
        return {}
    middle = float(np.median(ratios))
    return {
        "sooner": Finding(
            middle <= SOONER,
            f"a designed motion has the error of exciting after {middle:.2f} of its time, in the "
            f"median (wanted {SOONER:g})",
            {"median": finite(middle)},
        )
    }
