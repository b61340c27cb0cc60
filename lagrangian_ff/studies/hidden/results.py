"""The judgements of the study, counted: numbers, table and figure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from scipy.stats import beta

from lagrangian_ff.arm.hidden import HIDDEN
from lagrangian_ff.report.colours import FAINT, INK
from lagrangian_ff.report.style import new_figure, styled
from lagrangian_ff.studies.hidden.cases import SIZES
from lagrangian_ff.studies.hidden.plants import Built, Plant
from lagrangian_ff.studies.hidden.verdicts import Judgement, Outcome
from lagrangian_ff.studies.study import Line, Results, done, row

REACHED = 0.7
"""A plant that shows less than this share of the size wanted counts under what it shows."""
VISIBLE = (0.0, 0.01, 0.02, 0.05, 0.10, 1.0)
"""Edges of the bins of what plain friction cannot stand in for, as a share of the torque."""
CLOSE = 1.1
"""A model is as good as the true structure where its error is within this of it."""
LEGEND = {
    Outcome.RIGHT: ("#2b8a3e", "right"),
    Outcome.CLASS: ("#8ce99a", "right, as a class"),
    Outcome.PART: ("#74c0fc", "one of two"),
    Outcome.WRONG: ("#c92a2a", "wrong"),
    Outcome.NOTHING: ("#dee2e6", "nothing confirmed"),
}
LEAST, MOST = 0.8, 3.0
"""Ratios of errors beyond these are drawn at the edge."""
CENTRED: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 7}
DOTS: dict[str, Any] = {"color": "#1864ab", "alpha": 0.45, "markersize": 3.5, "markeredgewidth": 0}


@dataclass(frozen=True)
class Judged:
    """A case that is done.

    Attributes:
        case: its name.
        group: see `HiddenCase.group`.
        hidden: the effects in the plant.
        judgement: of the diagnosis.
        warned: the diagnosis said that this motion cannot show what is hidden.
        ratio: the error after adding over that of the true structure; None without such.
    """

    case: str
    group: str
    hidden: Sequence[Built]
    judgement: Judgement
    warned: bool
    ratio: float | None

    @classmethod
    def of(cls, line: Line) -> "Judged":
        """Return the case of a line that did not fail."""
        hidden = Plant.of(line["plant"]).hidden
        cannot = {(one["effect"], one["joint"]) for one in line["record"].get("not_observable", ())}
        warned = all(
            any((name, joint) in cannot for name in one.catalogue for joint in ("all", *one.joints))
            for one in hidden
        )
        judgement = Judgement.of(line["judgement"])
        return cls(line["case"], line["group"], hidden, judgement, warned, line["ratio"])

    @property
    def size(self) -> float:
        """Return the size that its first effect counts under."""
        return counted_size(self.hidden[0])


def counted_size(hidden: Built) -> float:
    """Return the size wanted, or the next to what the physics reached where that is less."""
    wanted, reached = hidden.size, max(hidden.reached[0], 1e-6)
    if reached > REACHED * wanted:
        return wanted
    return min(SIZES, key=lambda size: abs(np.log(size / reached)))


@dataclass(frozen=True)
class Counts:
    """Cases counted by outcome.

    Attributes:
        of: the number of each outcome.
        cases: all of them.
        with_false: not wrong, but with a false claim beside the right one.
        suggested: with a truth that is suggested and not claimed.
        warned: of nothing, where the diagnosis said that this motion cannot show the effect.
    """

    of: Mapping[Outcome, int]
    cases: int
    with_false: int
    suggested: int
    warned: int

    @classmethod
    def count(cls, judged: Sequence[Judged]) -> "Counts":
        """Count cases."""
        outcomes = [one.judgement.outcome for one in judged]
        return cls(
            {outcome: outcomes.count(outcome) for outcome in Outcome},
            len(judged),
            sum(
                bool(one.judgement.false) and one.judgement.outcome is not Outcome.WRONG
                for one in judged
            ),
            sum(bool(one.judgement.suggested) for one in judged),
            sum(one.judgement.outcome is Outcome.NOTHING and one.warned for one in judged),
        )

    def record(self) -> dict[str, int]:
        """Return the counts as JSON holds them."""
        counts = {outcome.value: count for outcome, count in self.of.items()}
        beside = {"with_false": self.with_false, "suggested": self.suggested, "told": self.warned}
        return {**counts, "cases": self.cases, **beside}


@dataclass(frozen=True)
class Claims:
    """Claims in cases where every claim is wrong.

    Attributes:
        cases: their number.
        claims: the claims of those with any, by case.
    """

    cases: int
    claims: Mapping[str, Sequence[str]]

    @property
    def high(self) -> float:
        """Return the upper end of the 95 % interval of the wrong share (Clopper and Pearson)."""
        wrong = len(self.claims)
        if wrong == self.cases:
            return 1.0
        return float(beta.ppf(0.975, wrong + 1, self.cases - wrong))

    @classmethod
    def of(cls, judged: Sequence[Judged]) -> "Claims":
        """Collect the claims of cases."""
        return cls(len(judged), {e.case: e.judgement.false for e in judged if e.judgement.false})

    def record(self) -> dict[str, Any]:
        """Return the claims as JSON holds them."""
        claims = {case: list(false) for case, false in self.claims.items()}
        return {"cases": self.cases, "wrong": len(claims), "high": self.high, "claims": claims}


def _ratio_record(ratios: Sequence[float]) -> dict[str, Any]:
    if not ratios:
        return {}
    low, middle, high = np.quantile(ratios, (0.1, 0.5, 0.9)).tolist()
    within = float(np.mean(np.array(ratios) <= CLOSE))
    return {"low": low, "median": middle, "high": high, "within_1.1": within, "each": ratios}


BySize = Mapping[float, Counts]


@dataclass(frozen=True)
class HiddenResults(Results):
    """The judgements, counted.

    Attributes:
        sizes: effects alone, by size, but for those that are absorbed.
        absorbed: effects alone that a kernel free in position holds, so that nothing is right too.
        visible: as `sizes`, by the part that friction of the joint's own kind cannot stand in for.
        pairs: two effects, by size.
        effects: effects alone by name and size.
        clean, outside: cases with nothing hidden, or nothing of the catalogue.
        ratio: by size, errors after adding over those of the true structure.
    """

    sizes: BySize
    absorbed: BySize
    visible: Mapping[tuple[float, float], Counts]
    pairs: BySize
    effects: Mapping[str, BySize]
    clean: Claims
    outside: Claims
    ratio: Mapping[float, Sequence[float]]

    @classmethod
    def of(cls, lines: Sequence[Line]) -> "HiddenResults":
        """Count the judgements of lines; those with `failed` are counted nowhere else."""
        groups: dict[str, list[Judged]] = {"alone": [], "pair": [], "clean": [], "outside": []}
        for line in done(lines):
            judged = Judged.of(line)
            groups[judged.group].append(judged)
        alone = groups["alone"]
        firm, absorbed = (
            [one for one in alone if one.hidden[0].absorbed is holds] for holds in (False, True)
        )
        named = {name: [e for e in alone if e.hidden[0].effect == name] for name in HIDDEN}
        effects = {name: _by_size(some) for name, some in named.items() if some}
        ratio = {
            size: [one.ratio for one in some if one.ratio is not None]
            for size, some in _grouped(firm).items()
        }
        sized = _by_size(firm), _by_size(absorbed), _by_visible(firm), _by_size(groups["pair"])
        claims = Claims.of(groups["clean"]), Claims.of(groups["outside"])
        return cls(lines, None, *sized, effects, *claims, ratio)

    def numbers(self) -> dict[str, Any]:
        return {
            "sizes": _record(self.sizes),
            "absorbed": _record(self.absorbed),
            "visible": {f"{a:g}-{b:g}": each.record() for (a, b), each in self.visible.items()},
            "pairs": _record(self.pairs),
            "effects": {name: _record(by_size) for name, by_size in self.effects.items()},
            "clean": self.clean.record(),
            "outside": self.outside.record(),
            "ratio": {f"{size:g}": _ratio_record(each) for size, each in self.ratio.items()},
        }

    def text(self) -> list[str]:
        text = [f"{len(self.lines)} cases"]
        ranges = {" to ".join(map(_bare, ends)): each for ends, each in self.visible.items()}
        blocks: tuple[tuple[str, Mapping[str, Counts]], ...] = (
            ("one effect, by size", _by_name(self.sizes)),
            ("one effect, by what plain friction cannot stand in for", ranges),
            (
                "one that some models hold already, so that nothing is right too, by size",
                _by_name(self.absorbed),
            ),
            ("two effects, by size", _by_name(self.pairs)),
        )
        medians = {_bare(size): f"{np.median(e):.2f}" for size, e in self.ratio.items() if e}
        for place, (title, rows) in enumerate(blocks):
            if rows:
                head = ("cases", *(outcome.value for outcome in Outcome), "warned", "ratio")
                text += ["", f"{title}:", row("", head, 12)]
            for name, each in rows.items():
                shares = [f"{n / each.cases:.2f}" for n in (*each.of.values(), each.warned)]
                last = "" if place else medians.get(name, "")
                text.append(row(f"{name} %", [str(each.cases), *shares, last], 12))
        if any(rows for _, rows in blocks):
            said = "nothing confirmed, and the diagnosis said that this motion cannot show it"
            text += ["", f"warned: {said}"]
        if self.effects:
            sizes = sorted({size for by_size in self.effects.values() for size in by_size})
            text += ["", "by effect, right or as a class / wrong / cases:"]
            text.append(row("", [f"{_bare(size)} %" for size in sizes], 20))
            for name, by_size in self.effects.items():
                text.append(row(name, [_cell(by_size.get(size)) for size in sizes], 20))
        for title, of in (("nothing hidden", self.clean), ("outside the catalogue", self.outside)):
            if of.cases:
                found = f"{len(of.claims)} of {of.cases} with a confirmed effect"
                text += ["", f"{title}: {found} (at most {of.high:.0%} with 95 % confidence)"]
                text += [f"  {case}: {'; '.join(said)}" for case, said in of.claims.items()]
        return text

    def figure(self) -> Figure:
        """Draw outcomes by size and by effect, and what adding is worth."""
        with styled():
            drawn = new_figure(2.9 + 0.24 * max(len(self.effects), 6))
            grid = drawn.add_gridspec(2, 2, width_ratios=(1.0, 1.1), height_ratios=(1.0, 0.9))
            _draw_bars(drawn.add_subplot(grid[0, 0]), self)
            _draw_ratios(drawn.add_subplot(grid[1, 0]), self.ratio)
            _draw_effects(drawn.add_subplot(grid[:, 1]), self.effects)
            patches = [Patch(color=colour, label=label) for colour, label in LEGEND.values()]
            drawn.legend(handles=patches, loc="outside lower center", ncol=len(patches))
        return drawn


def _grouped(judged: Sequence[Judged]) -> dict[float, list[Judged]]:
    sizes = sorted({one.size for one in judged})
    return {size: [one for one in judged if one.size == size] for size in sizes}


def _by_size(judged: Sequence[Judged]) -> BySize:
    return {size: Counts.count(some) for size, some in _grouped(judged).items()}


def _by_visible(judged: Sequence[Judged]) -> dict[tuple[float, float], Counts]:
    bins = np.digitize([one.hidden[0].visible[0] for one in judged], VISIBLE[1:-1])
    return {
        ends: Counts.count(some)
        for k, ends in enumerate(pairwise(VISIBLE))
        if (some := [one for one, bin_ in zip(judged, bins, strict=True) if bin_ == k])
    }


def _record(by_size: BySize) -> dict[str, dict[str, int]]:
    return {f"{size:g}": each.record() for size, each in by_size.items()}


def _by_name(by_size: BySize) -> dict[str, Counts]:
    return {_bare(size): each for size, each in by_size.items()}


def _bare(size: float) -> str:
    """Return a size in per cent, without the sign."""
    return f"{100.0 * size:g}"


def _cell(each: Counts | None) -> str:
    if each is None:
        return "-"
    right = each.of[Outcome.RIGHT] + each.of[Outcome.CLASS]
    return f"{right}/{each.of[Outcome.WRONG]}/{each.cases}"


def _draw_bars(axes: Axes, results: HiddenResults) -> None:
    bars: list[tuple[str, Mapping[Outcome, int], int]] = []
    bars += [(f"{_bare(size)} %", e.of, e.cases) for size, e in results.sizes.items()]
    bars += [(f"two,\n{_bare(size)} %", e.of, e.cases) for size, e in results.pairs.items()]
    for name, each in (("none", results.clean), ("outside", results.outside)):
        if each.cases:
            wrong = len(each.claims)
            counts = {Outcome.WRONG: wrong, Outcome.NOTHING: each.cases - wrong}
            bars.append((name, counts, each.cases))
    for place, (_, of, cases) in enumerate(bars):
        below = 0.0
        for outcome, (colour, _) in LEGEND.items():
            share = of.get(outcome, 0) / cases
            axes.bar(place, share, 0.72, bottom=below, color=colour)
            if share > 0.06:
                shade = "white" if outcome in (Outcome.RIGHT, Outcome.WRONG) else INK
                axes.text(place, below + 0.5 * share, f"{share:.2f}", color=shade, **CENTRED)
            below += share
        axes.text(place, 1.01, f"{cases}", ha="center", fontsize=7, color=FAINT)
    axes.set_xticks(range(len(bars)), [name for name, _, _ in bars])
    axes.set_ylim(0.0, 1.06)
    axes.grid(visible=False, axis="x")
    axes.set_ylabel("share of cases")
    axes.set_title("What is said, by size of the hidden effect")


def _draw_effects(axes: Axes, effects: Mapping[str, BySize]) -> None:
    sizes = sorted({size for by_size in effects.values() for size in by_size})
    for y, by_size in enumerate(effects.values()):
        for x, size in enumerate(sizes):
            if size not in by_size:
                continue
            counts, left = by_size[size], x - 0.46
            for outcome, (colour, _) in LEGEND.items():
                width = 0.92 * counts.of[outcome] / counts.cases
                axes.barh(y, width, 0.8, left=left, color=colour)
                left += width
    _size_ticks(axes, sizes)
    axes.set_yticks(range(len(effects)), list(effects))
    axes.set_ylim(max(len(effects), 1) - 0.5, -0.5)
    axes.grid(visible=False)
    axes.set_title("By effect; each cell shows its cases")


def _draw_ratios(axes: Axes, ratios: Mapping[float, Sequence[float]]) -> None:
    random = np.random.default_rng(0)
    for place, values in enumerate(ratios.values()):
        spread = place + random.uniform(-0.22, 0.22, size=len(values))
        axes.plot(spread, np.clip(values, LEAST, MOST), "o", **DOTS)
        if values:
            axes.plot([place - 0.3, place + 0.3], [np.median(values)] * 2, color=INK)
    axes.axhline(CLOSE, color=LEGEND[Outcome.WRONG][0], linewidth=0.8, linestyle=(0, (4, 3)))
    axes.set_yscale("log")
    axes.set_yticks([0.8, 1.0, 1.2, 1.5, 2.0, 3.0], ["0.8", "1", "1.2", "1.5", "2", "3"])
    axes.minorticks_off()
    axes.set_ylim(0.95 * LEAST, 1.05 * MOST)
    _size_ticks(axes, list(ratios))
    axes.grid(visible=False, axis="x")
    axes.set_ylabel("error ratio")
    axes.set_title("Error after adding over that of the true structure")


def _size_ticks(axes: Axes, sizes: Sequence[float]) -> None:
    axes.set_xticks(range(len(sizes)), [f"{_bare(size)} %" for size in sizes])
    axes.set_xlim(-0.5, max(len(sizes), 1) - 0.5)
