"""The judgements of the study, counted: numbers, targets, table and figure."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from lagrangian_ff.arm import MOTIONS
from lagrangian_ff.report.style import new_figure, styled
from lagrangian_ff.studies.hidden.results import LEGEND, counted_size
from lagrangian_ff.studies.hidden.verdicts import Judgement, Outcome
from lagrangian_ff.studies.nuisances.drawn import CHANCES
from lagrangian_ff.studies.nuisances.plants import NuisancePlant
from lagrangian_ff.studies.study import Finding, Line, Results, done, row, shown

ENOUGH = 30.0
"""s of motion, without rests, from which the targets for names hold."""
MOVING = (0.0, 15.0, ENOUGH, 45.0, np.inf)
"""Edges of the bins of s in motion."""
RATES = (0.0, 200.0, 1000.0, np.inf)
WRONG, CLEAN, OUTSIDE = 0.03, 0.03, 0.05
"""Largest shares of arms with a wrong name: with an effect, with none, with one outside."""
NAMED = {0.10: 0.9, 0.05: 0.75}
"""Least share of effects that are named, by size."""
RAISED = 1.001
"""Adding raises the unseen error if it is beyond this of that before."""
LARGE = 0.05
"""Least size of the effects of which the share named is shown by nuisance."""
NAME, CELL = 26, 10


@dataclass(frozen=True)
class Judged:
    """An arm that is done.

    Attributes:
        case, group: its name and its group.
        size: that of its effect; None without one of the catalogue.
        judgement: of the diagnosis.
        nuisances: the names of those that it has.
        motion: their kind.  moving: s.  rate: Hz.
        refused: whether the diagnosis refused to judge.
        raised: confirmed findings that raise the unseen error, in words.
    """

    case: str
    group: str
    size: float | None
    judgement: Judgement
    nuisances: frozenset[str]
    motion: str
    moving: float
    rate: float
    refused: bool
    raised: tuple[str, ...]

    @classmethod
    def of(cls, line: Line) -> "Judged":
        """Return the arm of a line that did not fail."""
        plant = NuisancePlant.of(line["plant"])
        drawn = plant.nuisances
        raised = tuple(
            f"{one['effect']} on {one['joint']}: {one['before']:.4g} to {one['after']:.4g} N·m"
            for one in line["added"]
            if one["after"] > RAISED * one["before"]
        )
        return cls(
            case=line["case"],
            group=line["group"],
            size=counted_size(plant.hidden[0]) if line["group"] == "alone" else None,
            judgement=Judgement.of(line["judgement"]),
            nuisances=frozenset(name for name, there in drawn.present.items() if there),
            motion=drawn.motion,
            moving=min(plant.moving),
            rate=drawn.rate,
            refused=line["refused"] is not None,
            raised=raised,
        )


@dataclass(frozen=True)
class Shares:
    """Arms counted.

    Attributes:
        cases: all of them.
        able: those with an effect of the catalogue.
        named: of these, those whose effect is named.  as_class: as one of a class only.
        wrong: those with a name of something that is not there.
        refused: those whose recordings the diagnosis refused to judge.
    """

    cases: int
    able: int
    named: int
    as_class: int
    wrong: int
    refused: int

    @classmethod
    def count(cls, judged: Sequence[Judged]) -> "Shares":
        """Count arms."""
        able = [one.judgement.outcome for one in judged if one.size is not None]
        return cls(
            cases=len(judged),
            able=len(able),
            named=able.count(Outcome.RIGHT),
            as_class=able.count(Outcome.CLASS),
            wrong=sum(bool(one.judgement.false) for one in judged),
            refused=sum(one.refused for one in judged),
        )

    @property
    def named_share(self) -> float:
        """Return the share of effects that are named, alone or in a class; nan of none."""
        return (self.named + self.as_class) / self.able if self.able else float("nan")

    @property
    def wrong_share(self) -> float:
        """Return the share of arms with a wrong name; nan of none."""
        return self.wrong / self.cases if self.cases else float("nan")

    def cells(self) -> list[str]:
        """Return the cells of a row of the table."""
        shares = (
            (self.named + self.as_class, self.able),
            (self.as_class, self.able),
            (self.wrong, self.cases),
            (self.refused, self.cases),
        )
        return [str(self.cases), *(f"{n / of:.2f}" if of else "-" for n, of in shares)]


Table = Mapping[str, Shares]
HEAD = ("arms", "named", "as class", "wrong", "refused")


@dataclass(frozen=True)
class NuisanceResults(Results):
    """The judgements, counted.

    Attributes:
        sizes: arms with one effect of the catalogue, by its size.
        long: those of them with 30 s of motion.
        groups: all arms, by group.
        nuisances: all arms with, and without, each nuisance; named are effects of 5 % and more.
        motions, moving, rates: all arms by kind of motion, s of it, and Hz; named likewise.
        names: how often each wrong name was given.
        false: wrong names by case.
        raised: confirmed findings by case whose adding raised the unseen error.
    """

    sizes: Mapping[float, Shares]
    long: Mapping[float, Shares]
    groups: Table
    nuisances: Mapping[str, tuple[Shares, Shares]]
    motions: Table
    moving: Table
    rates: Table
    names: Mapping[str, int]
    false: Mapping[str, Sequence[str]]
    raised: Mapping[str, Sequence[str]]

    @classmethod
    def of(cls, lines: Sequence[Line]) -> "NuisanceResults":
        """Count the judgements of lines; those with `failed` are counted nowhere else."""
        judged = [Judged.of(line) for line in done(lines)]
        alone = [one for one in judged if one.size is not None]
        # Small effects are missed for their size, whatever else the arm has.
        large = [one for one in judged if one.size is None or one.size >= LARGE]
        sizes, long = _by_size(alone), _by_size([one for one in alone if one.moving >= ENOUGH])
        groups = _table(judged, lambda one: one.group, ("clean", "alone", "outside"))
        claimed = (name for one in judged for name in one.judgement.false)
        return cls(
            lines,
            shown(_targets(sizes, long, groups, judged)),
            sizes,
            long,
            groups,
            {name: _both(large, name) for name in CHANCES},
            _table(large, lambda one: one.motion, MOTIONS),
            _binned(large, lambda one: one.moving, MOVING, "s"),
            _binned(large, lambda one: one.rate, RATES, "Hz"),
            dict(Counter(claim.partition(" on ")[0] for claim in claimed).most_common()),
            {one.case: one.judgement.false for one in judged if one.judgement.false},
            {one.case: one.raised for one in judged if one.raised},
        )

    def numbers(self) -> dict[str, Any]:
        return {
            "sizes": {f"{size:g}": asdict(each) for size, each in self.sizes.items()},
            "long": {f"{size:g}": asdict(each) for size, each in self.long.items()},
            "nuisances": {
                name: {"with": asdict(there), "without": asdict(absent)}
                for name, (there, absent) in self.nuisances.items()
            },
            **{
                name: {key: asdict(each) for key, each in table.items()}
                for name, table in self._tables().items()
            },
            "names": dict(self.names),
            "false": {case: list(claims) for case, claims in self.false.items()},
            "raised": {case: list(words) for case, words in self.raised.items()},
        }

    def _tables(self) -> dict[str, Table]:
        tables = self.groups, self.motions, self.moving, self.rates
        return dict(zip(("groups", "motions", "moving", "rates"), tables, strict=True))

    def text(self) -> list[str]:
        text = [f"{len(self.lines)} arms"]
        blocks: dict[str, Table] = {
            "all arms": self.groups,
            "one effect of the catalogue, by size": _percents(self.sizes),
            f"of these, those with {ENOUGH:g} s of motion": _percents(self.long),
            "by kind of motion (effects of 5 % and more)": self.motions,
            "by time in motion": self.moving,
            "by rate": self.rates,
        }
        for title, rows in blocks.items():
            if rows:
                text += ["", row(title, [], NAME), row("", HEAD, NAME, CELL)]
                text += [row(name, each.cells(), NAME, CELL) for name, each in rows.items()]
        if self.nuisances and self.lines:
            head = ("arms", "named", "wrong", "without:", "named", "wrong")
            text += ["", "  with each nuisance, and without it", row("", head, NAME, CELL)]
        for name, pair in self.nuisances.items() if self.lines else ():
            halves = [[cells[0], cells[1], cells[3]] for cells in (each.cells() for each in pair)]
            text.append(row(name, [*halves[0], *halves[1]], NAME, CELL))
        if self.names:
            often = ", ".join(f"{name} ({count})" for name, count in self.names.items())
            text += ["", f"wrong names: {often}"]
        text += [f"  {case}: {'; '.join(said)}" for case, said in self.false.items()]
        if self.raised:
            text += ["", "confirmed, and adding it raises the unseen error:"]
            text += [f"  {case}: {'; '.join(said)}" for case, said in self.raised.items()]
        return text

    def figure(self) -> Figure:
        """Draw what is named by size and by time in motion, and what each nuisance does."""
        with styled():
            drawn = new_figure(5.2)
            grid = drawn.add_gridspec(2, 2)
            _draw_sizes(drawn.add_subplot(grid[0, 0]), self.sizes)
            _draw_moving(drawn.add_subplot(grid[1, 0]), self.moving)
            _draw_nuisances(drawn.add_subplot(grid[:, 1]), self.nuisances)
            shown_ = (Outcome.RIGHT, Outcome.CLASS, Outcome.WRONG)
            patches = [Patch(color=LEGEND[each][0], label=LEGEND[each][1]) for each in shown_]
            drawn.legend(handles=patches, loc="outside lower center", ncol=len(patches))
        return drawn


def _by_size(judged: Sequence[Judged]) -> dict[float, Shares]:
    sizes = sorted({one.size for one in judged if one.size is not None})
    return {size: Shares.count([one for one in judged if one.size == size]) for size in sizes}


def _table(
    judged: Sequence[Judged], key: Callable[[Judged], str], names: Iterable[str]
) -> dict[str, Shares]:
    """Return the shares of each name that some arms have."""
    some = {name: [one for one in judged if key(one) == name] for name in names}
    return {name: Shares.count(each) for name, each in some.items() if each}


def _binned(
    judged: Sequence[Judged], value: Callable[[Judged], float], edges: Sequence[float], unit: str
) -> dict[str, Shares]:
    names = [f"{low:g} to {high:g} {unit}" for low, high in pairwise(edges[:-1])]
    names.append(f"{edges[-2]:g} {unit} and more")
    return _table(judged, lambda one: names[int(np.digitize(value(one), edges[1:-1]))], names)


def _both(judged: Sequence[Judged], nuisance: str) -> tuple[Shares, Shares]:
    """Return the shares of arms with a nuisance, and of those without it."""
    there = [one for one in judged if nuisance in one.nuisances]
    absent = [one for one in judged if nuisance not in one.nuisances]
    return Shares.count(there), Shares.count(absent)


def _percents(by_size: Mapping[float, Shares]) -> dict[str, Shares]:
    return {f"{100.0 * size:g} %": each for size, each in by_size.items()}


def _targets(
    sizes: Mapping[float, Shares],
    long: Mapping[float, Shares],
    groups: Table,
    judged: Sequence[Judged],
) -> dict[str, Finding | None]:
    found: dict[str, Finding | None] = {}
    if sizes:
        share = {size: each.wrong_share for size, each in sizes.items()}
        said = ", ".join(f"{s:.2f} at {100.0 * size:g} %" for size, s in share.items())
        figures = {f"{size:g}": s for size, s in share.items()}
        holds = max(share.values()) <= WRONG
        says = f"at most {WRONG:g} of the arms with an effect get a wrong name: {said}"
        found["wrong"] = Finding(holds, says, {"wrong": figures})
    for size, least in NAMED.items():
        if size in long:
            each = long[size]
            says = (
                f"of effects of {100.0 * size:g} % with {ENOUGH:g} s of motion at least {least:g} "
                f"are named: {each.named_share:.2f} of {each.able}"
            )
            figures = {"named": each.named_share, "cases": each.able}
            found[f"named_{100.0 * size:g}"] = Finding(each.named_share >= least, says, figures)
    for name, most in (("clean", CLEAN), ("outside", OUTSIDE)):
        if name in groups:
            each = groups[name]
            what = "nothing hidden" if name == "clean" else "something outside the catalogue"
            says = (
                f"at most {most:g} of the arms with {what} get a wrong name: "
                f"{each.wrong_share:.2f} of {each.cases}"
            )
            found[name] = Finding(each.wrong_share <= most, says, {"wrong": each.wrong_share})
    if judged:
        count = sum(len(one.raised) for one in judged)
        says = f"nothing is confirmed whose adding raises the unseen error: {count} findings do"
        found["raised"] = Finding(count == 0, says, {"findings": count})
    return found


def _draw_sizes(axes: Axes, sizes: Mapping[float, Shares]) -> None:
    for place, each in enumerate(sizes.values()):
        below = 0.0
        for outcome, count in ((Outcome.RIGHT, each.named), (Outcome.CLASS, each.as_class)):
            axes.bar(place, count / each.able, 0.5, bottom=below, color=LEGEND[outcome][0])
            below += count / each.able
    wrong = [each.wrong_share for each in sizes.values()]
    colour = LEGEND[Outcome.WRONG][0]
    axes.plot(range(len(wrong)), wrong, "o", color=colour)
    axes.axhline(WRONG, color=colour, linewidth=0.8, linestyle=(0, (4, 3)))
    axes.set_xticks(range(len(sizes)), list(_percents(sizes)))
    axes.set_ylim(0.0, 1.0)
    axes.set_title("One effect, by size: share of arms")


def _draw_moving(axes: Axes, moving: Table) -> None:
    for of, outcome in (("named_share", Outcome.RIGHT), ("wrong_share", Outcome.WRONG)):
        values = [getattr(each, of) for each in moving.values()]
        axes.plot(range(len(values)), values, "o-", color=LEGEND[outcome][0])
    axes.set_xticks(range(len(moving)), list(moving))
    axes.set_ylim(0.0, 1.0)
    axes.set_title("By time in motion: named, and with a wrong name")


def _draw_nuisances(axes: Axes, nuisances: Mapping[str, tuple[Shares, Shares]]) -> None:
    for of, outcome in (("named_share", Outcome.RIGHT), ("wrong_share", Outcome.WRONG)):
        colour = LEGEND[outcome][0]
        for place, pair in enumerate(nuisances.values()):
            there, absent = (getattr(each, of) for each in pair)
            axes.plot([absent, there], [place, place], color=colour, linewidth=1.0)
            axes.plot(absent, place, "o", color="white", markeredgecolor=colour)
            axes.plot(there, place, "o", color=colour)
    names = [name.replace("_", " ") for name in nuisances]
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(max(len(names), 1) - 0.5, -0.5)
    axes.set_xlim(-0.02, 1.02)
    axes.set_title("Without (hollow) and with each nuisance")
