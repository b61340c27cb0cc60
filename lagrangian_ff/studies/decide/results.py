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
from lagrangian_ff.studies.decide.cases import BUDGET
from lagrangian_ff.studies.decide.outcomes import Investigated, Opened, Taken, is_open, is_too_small
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
VISIBLE = (0.1, 0.3)
"""Below the first an effect hardly shows, above the second it is plain: its torque that plain
friction cannot imitate, over the torque that the diagnosis leaves unexplained."""
FEWEST = 5
"""Cases from which on a share is a finding."""


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
        small: cases that are left out, since their arm cannot have such an effect so large.
    """

    opened: Sequence[Opened]
    decided: int
    investigated: Mapping[str, Sequence[Investigated]]
    taken: Sequence[Taken]
    sooner: Mapping[str, float]
    small: Sequence[str] = ()

    @classmethod
    def of(cls, lines: Sequence[Line]) -> "DecideResults":
        """Return the results of all or some of the lines."""
        every = done(lines)
        small = [line["case"] for line in every if is_too_small(line)]
        sound = [line for line in every if not is_too_small(line)]
        motion = [line for line in sound if line["group"] == "motion"]
        opened = [Opened.of(line) for line in motion if is_open(line)]
        groups: dict[str, list[Investigated]] = {group: [] for group in WORDS}
        for line in sound:
            if line["group"] in groups:
                groups[line["group"]].append(Investigated.of(line))
        taken = [Taken.of(line) for line in sound if line["group"] == "outside"]
        early = {line["case"]: ratio(line) for line in sound if line["group"] == "sooner"}
        found = shown({
            **_of_motions(opened),
            **_of_investigations(groups),
            **_of_unlisted(taken),
            **_of_time(list(early.values())),
        })  # fmt: skip
        decided = len(motion) - len(opened)
        return cls(lines, found, opened, decided, groups, taken, early, small)

    def numbers(self) -> dict[str, Any]:
        return {
            "decided by the usual motion": self.decided,
            "too small": list(self.small),
            "open": [
                {
                    "case": one.case,
                    "designed": one.designed.record() if one.designed else None,
                    "template": one.template.record() if one.template else None,
                    "nats": one.nats,
                    "expected": one.expected,
                    "visible": one.visible,
                    "attainable": one.attainable,
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
                        "early": one.early,
                        "left": one.left,
                        "error": one.error,
                        "promised": one.promised,
                        "visible": one.visible,
                        "attainable": one.attainable,
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
        lines += [
            "",
            row("investigated", ["arms", "named", "class", "wrong", "early", "s moved"], 20),
        ]
        for group, some in self.investigated.items():
            named, alike, wrong, _ = _counted([one.judgement for one in some])
            moved = f"{np.median([one.moved for one in some]):.0f}" if some else "-"
            early = str(sum(one.early for one in some))
            counts = [str(len(some)), named, alike, wrong, early, moved]
            lines.append(row(WORDS[group], counts, 20))
        lines += ["", row("named, by its visible part", ["hardly", "shows", "plain"], 26)]
        opened = [(one.visible, one.designed) for one in self.opened]
        lines.append(row("the designed one", _by_visibility(opened), 26))
        for group in FOUND:
            seen = [(one.visible, one.judgement) for one in self.investigated[group]]
            lines.append(row(f"investigated, {WORDS[group]}", _by_visibility(seen), 26))
        if self.small:
            lines.append(
                f"left out, since an arm cannot have its effect so large: {len(self.small)}"
            )
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
            left.loglog(ends, ends, color=BEFORE, label="as many")
            left.loglog(ends, RATIO * ends, color=BEFORE, linestyle="--",
                        label=f"{RATIO:g} times as many: wanted")  # fmt: skip
            left.legend()
            left.set_xlabel("nats with the template's motion")
            left.set_ylabel("with the designed one")
            left.set_title("the true effect's log Bayes factor, equal time")
            colours = {"five": GOOD, "two": AFTER, "clean": INK}
            for group, some in self.investigated.items():
                when = sorted(one.when for one in some if one.when is not None)
                if some and group != "clean":
                    share = np.arange(1, len(when) + 1) / len(some)
                    right.step([0.0, *when, BUDGET], [0.0, *share, share[-1] if when else 0.0],
                               where="post", color=colours[group], label=WORDS[group])  # fmt: skip
            right.set_ylim(0.0, 1.05)
            right.set_xlabel("s of motion")
            right.set_ylabel("share found and added")
            right.set_title("investigations")
            if right.lines:
                right.legend()
        return figure


def _is_right(one: Judgement | None) -> bool:
    return one is not None and one.outcome is Outcome.RIGHT


def _by_visibility(seen: Sequence[tuple[float | None, Judgement | None]]) -> list[str]:
    """Return how many are named, of how many, in each range of `VISIBLE`."""
    known = [(visible, one) for visible, one in seen if visible is not None]
    bins = np.digitize([visible for visible, _ in known], VISIBLE)
    found: list[str] = []
    for number in range(len(VISIBLE) + 1):
        here = [one for (_, one), place in zip(known, bins, strict=True) if place == number]
        named = sum(map(_is_right, here))
        found.append(f"{named} of {len(here)}" if here else "-")
    return found


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
        floor = thresholds.USED.floor
        seen = [
            one for one in opened if _is_right(one.designed) or (one.attainable or 0.0) >= floor
        ]
        decided = sum(_is_right(one.designed) for one in seen)
        found["within reach"] = Finding(
            decided >= NAMED * len(seen),
            f"in {len(seen)} of {len(opened)} the effect's true torque shows in the designed "
            f"motion, by {floor:g} nats or more; {decided} of these are named",
            {"seen": len(seen), "named": decided},
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
            hidden = [one for one in some if not _is_right(one.judgement)]
            share, floor = 1.0 - len(hidden) / len(some), thresholds.USED.floor
            little = sum((one.attainable or 0.0) < floor for one in hidden)
            never = sum((one.promised or 0.0) < floor for one in hidden)
            others = (
                f"; of the {len(hidden)} others, the true torque shows by less than {floor:g} nats "
                f"in {little}, and 30 s designed for it promise no more in {never}"
            )
            found[group] = Finding(
                share >= wanted,
                f"investigations find and add {share:.2f} of effects of {WORDS[group]} "
                f"(wanted {wanted:g}){others if hidden else ''}",
                {"share": share, "hidden": len(hidden), "too little": little, "never": never},
            )
    if len(groups["clean"]) >= FEWEST:
        wrong_names = sum(bool(one.judgement.false) for one in groups["clean"])
        early = sum(one.early for one in groups["clean"])
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
