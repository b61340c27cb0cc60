"""The numbers of the study, and their table in words."""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.stats import beta

from lagrangian_ff.arm.hidden import HIDDEN
from lagrangian_ff.studies.common.study import failures, failures_told
from lagrangian_ff.studies.hidden.cases import SIZES
from lagrangian_ff.studies.hidden.verdicts import OUTCOMES

Lines = Sequence[dict[str, Any]]

REACHED = 0.7
"""A plant that shows less than this share of the size wanted counts under what it shows."""
VISIBLE = (0.0, 0.01, 0.02, 0.05, 0.10, 1.0)
"""Edges of the bins of what plain friction cannot stand in for, as a share of the torque."""


def summary(lines: Lines) -> dict[str, Any]:
    """Count the judgements.

    Args:
        lines: of the study; those with `failed` are counted as such and nowhere else.

    Returns:
        For JSON: `sizes`, from the size to the outcomes of effects alone (those that a kernel
        free in position holds already, so that nothing is right too, stand in `absorbed`), with
        `told`, the cases of nothing in which the diagnosis says that this motion cannot show the
        effect; `visible`, the same by the part of the size that friction of the joint's own kind
        cannot stand in for; `pairs`, by size;
        `effects`, from name and size to outcomes; `clean` and `outside`, cases and claims made in
        them; `ratio`, the error after adding over that of the true structure, by size.
    """
    judged = [line for line in lines if "failed" not in line]
    alone = [line for line in judged if line["group"] == "alone"]
    firm = [line for line in alone if not line["plant"]["hidden"][0]["absorbed"]]
    return {
        "cases": len(lines),
        "failed": failures(lines),
        "sizes": _by_size(firm),
        "absorbed": _by_size(line for line in alone if line not in firm),
        "visible": _by_visible(firm),
        "pairs": _by_size(line for line in judged if line["group"] == "pair"),
        "effects": {
            name: _by_size(line for line in alone if line["plant"]["hidden"][0]["effect"] == name)
            for name in HIDDEN
            if any(line["plant"]["hidden"][0]["effect"] == name for line in alone)
        },
        "clean": _claims(line for line in judged if line["group"] == "clean"),
        "outside": _claims(line for line in judged if line["group"] == "outside"),
        "ratio": {size: _quantiles(ratios) for size, ratios in _ratios_by_size(lines).items()},
    }


def _size(line: dict[str, Any]) -> float:
    """The size wanted; where the physics cannot be made as strong, the next to what it reached."""
    hidden = line["plant"]["hidden"][0]
    wanted, reached = float(hidden["size"]), max(float(hidden["reached"][0]), 1e-6)
    if reached > REACHED * wanted:
        return wanted
    return min(SIZES, key=lambda size: abs(np.log(size / reached)))


def _sizes(lines: Iterable[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    held = list(lines)
    return {
        f"{size:g}": [line for line in held if _size(line) == size]
        for size in sorted({_size(line) for line in held})
    }


def _by_size(lines: Iterable[dict[str, Any]]) -> dict[str, dict[str, int]]:
    return {size: _outcomes(group) for size, group in _sizes(lines).items()}


def _by_visible(lines: Lines) -> dict[str, dict[str, int]]:
    bins = np.digitize([line["plant"]["hidden"][0]["visible"][0] for line in lines], VISIBLE[1:-1])
    return {
        f"{low:g}-{high:g}": _outcomes(group)
        for k, (low, high) in enumerate(pairwise(VISIBLE))
        if (group := [line for line, bin_ in zip(lines, bins, strict=True) if bin_ == k])
    }


def _outcomes(lines: Lines) -> dict[str, int]:
    found = [line["judgement"]["outcome"] for line in lines]
    counted = {str(name): found.count(name) for name in OUTCOMES}
    # A false claim beside the right one does not make a case wrong, and is not hidden either.
    extra = sum(
        bool(line["judgement"]["false"]) and line["judgement"]["outcome"] != "wrong"
        for line in lines
    )
    suggested = sum(bool(line["judgement"]["suggested"]) for line in lines)
    told = sum(line["judgement"]["outcome"] == "nothing" and _told(line) for line in lines)
    return {**counted, "cases": len(found), "with_false": extra, "suggested": suggested,
            "told": told}  # fmt: skip


def _told(line: dict[str, Any]) -> bool:
    """Whether the diagnosis said that this motion cannot show what was hidden."""
    cannot = {(one["effect"], one["joint"]) for one in line["record"]["not_observable"]}
    return all(
        any(
            (name, joint) in cannot
            for name in one["catalogue"]
            for joint in ("all", *one["joints"])
        )
        for one in line["plant"]["hidden"]
    )


def _claims(lines: Iterable[dict[str, Any]]) -> dict[str, Any]:
    held = list(lines)
    false = {
        line["case"]: line["judgement"]["false"] for line in held if line["judgement"]["false"]
    }
    return {"cases": len(held), "wrong": len(false), "high": _high(len(false), len(held)),
            "claims": false}  # fmt: skip


def _high(count: int, cases: int) -> float:
    """The upper end of the 95 % interval of a share (Clopper and Pearson)."""
    return 1.0 if count == cases else float(beta.ppf(0.975, count + 1, cases - count))


def _ratios_by_size(lines: Lines) -> dict[str, list[float]]:
    """The error ratios of the effects alone that no kernel holds already, by size."""
    firm = [
        line
        for line in lines
        if "failed" not in line
        and line["group"] == "alone"
        and not line["plant"]["hidden"][0]["absorbed"]
    ]
    return {
        size: [line["ratio"] for line in group if line["ratio"] is not None]
        for size, group in _sizes(firm).items()
    }


def _quantiles(ratios: list[float]) -> dict[str, Any]:
    if not ratios:
        return {}
    low, middle, high = np.quantile(ratios, (0.1, 0.5, 0.9)).tolist()
    within = float(np.mean(np.array(ratios) <= 1.1))
    return {"low": low, "median": middle, "high": high, "within_1.1": within, "each": ratios}


def table(numbers: dict[str, Any]) -> list[str]:
    """The summary as lines of text."""
    text = [f"{numbers['cases']} cases"]
    blocks = (
        ("one effect, by size", "sizes"),
        ("one effect, by what plain friction cannot stand in for", "visible"),
        ("one that some models hold already, so that nothing is right too, by size", "absorbed"),
        ("two effects, by size", "pairs"),
    )
    for title, key in blocks:
        if numbers[key]:
            text += ["", f"{title}:", _row(("", "cases", *OUTCOMES, "told", "ratio"), first=12)]
        for size, row in numbers[key].items():
            shares = [f"{row[name] / row['cases']:.2f}" for name in (*OUTCOMES, "told")]
            ratio = numbers["ratio"].get(size, {}).get("median") if key == "sizes" else None
            last = "" if ratio is None else f"{ratio:.2f}"
            text.append(_row([_percent(size), str(row["cases"]), *shares, last], first=12))
    if any(numbers[key] for _, key in blocks):
        text += ["", "told: of nothing, where the diagnosis said that this motion cannot show it"]
    if numbers["effects"]:
        text += ["", "by effect, right or as a class / wrong / cases:"]
        sizes = sorted({size for row in numbers["effects"].values() for size in row}, key=float)
        text.append(_row(["", *map(_percent, sizes)], first=20))
        for name, row in numbers["effects"].items():
            text.append(_row([name, *(_cell(row.get(size)) for size in sizes)], first=20))
    for title, key in (("nothing hidden", "clean"), ("outside the catalogue", "outside")):
        row = numbers[key]
        if row["cases"]:
            text += ["", f"{title}: {row['wrong']} of {row['cases']} with a confirmed effect "
                     f"(at most {row['high']:.0%} with 95 % confidence)"]  # fmt: skip
            text += [f"  {case}: {'; '.join(claims)}" for case, claims in row["claims"].items()]
    text += failures_told(numbers["failed"])
    return text


def _percent(size: str) -> str:
    """A size, or a range of sizes, in per cent."""
    return " to ".join(f"{100.0 * float(end):g}" for end in size.split("-")) + " %"


def _cell(row: dict[str, int] | None) -> str:
    if row is None:
        return "-"
    return f"{row['right'] + row['class']}/{row['wrong']}/{row['cases']}"


def _row(cells: Sequence[str], first: int) -> str:
    return ("  " + f"{cells[0]:<{first}}" + "".join(f"{cell:>9}" for cell in cells[1:])).rstrip()
