"""Which effects are missing: what was found at a glance, then the evidence for each."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.numbers import DASH, chance, percent, typeset
from lagrangian_ff.report import html
from lagrangian_ff.report.colours import AFTER, BAD, BEFORE, EFFECT, RESIDUAL
from lagrangian_ff.report.page import Section
from lagrangian_ff.report.plot import Plot, axis, band, embed, line
from lagrangian_ff.words import sentence, spoken, standing, where

KINDS = {"confirmed": "good", "suggested": "fair", "ambiguous": "fair"}
"""The colour of each verdict."""
MEANINGS = (
    "Confirmed: the effect, frozen as it was found, also lowers the error on data that the search "
    "did not see. Suggested: the evidence is strong, the confirmation is not. Ambiguous: another "
    "effect would explain this motion as well. Only what is confirmed should be added without a "
    "second look."
)


def summary_section(record: Mapping[str, Any]) -> Section:
    """Return a card for each finding that matters, and a table of all, from a diagnosis."""
    findings: Sequence[Mapping[str, Any]] = record["findings"]
    if not findings:
        return Section(
            "What is missing",
            "",
            html.paragraph("No effect of the catalogue earned its place on these recordings."),
        )
    every = record.get("joints", ())
    cards = [_card(one, every) for one in findings[:3]]
    rows = [
        [
            spoken(one["effect"]),
            where(one, every),
            _verdict(one),
            *(typeset(one.get(name)) for name in ("error_before", "error_after", "evidence_gain")),
            chance(one.get("p_value"), DASH),
        ]
        for one in findings
    ]
    header = ["effect", "joint", "verdict", "error before [N·m]", "after [N·m]", "gain", "p"]
    small = html.note(
        f"{MEANINGS} Errors are RMS on data held back from the search. Gain is in log evidence: by "
        "how much the effect makes the measured torques more likely. p is how often chance alone "
        "gives the best of all candidates so much."
    )
    body = html.cards(cards) + html.table(header, rows, words=3, strong=4) + small
    return Section("What is missing", "", body)


def evidence_section(record: Mapping[str, Any]) -> Section | None:
    """Return for each finding what it is, where it shows, its size, and whether it helps."""
    if not record["findings"]:
        return None
    return Section(
        "The evidence",
        "Left: what the model leaves, over the quantity in which the effect shows, and the effect "
        "as fitted. Right: the error of each block of held-back motion before and after.",
        "".join(_finding(one, record.get("joints", ())) for one in record["findings"]),
    )


def _verdict(found: Mapping[str, Any]) -> str:
    others = ", ".join(map(spoken, found.get("ambiguous_with") or []))
    word = standing(found)
    return f"{word} with {others}" if word == "ambiguous" and others else word


def _card(found: Mapping[str, Any], every: Sequence[str]) -> html.Card:
    before, after = found.get("error_before"), found.get("error_after")
    on = where(found, every)
    if before is None or after is None or not before > 0.0 or not math.isfinite(after / before):
        return html.Card(spoken(found["effect"]), f"on {on}", _verdict(found))
    fall = 1.0 - after / before
    # An error that rises is said as such, never as a negative fall.
    change = f"error {percent(abs(fall))} {'lower' if fall >= 0.0 else 'higher'}"
    return html.Card(
        spoken(found["effect"]),
        f"on {on}: {change} on held-back data",
        f"{typeset(before)} → {typeset(after)} N·m, {_verdict(found)}",
        True if standing(found) == "confirmed" else None,
    )


def _finding(found: Mapping[str, Any], every: Sequence[str]) -> str:
    on = where(found, every)
    heading = (
        f"<h3>{html.escape(spoken(found['effect']))} on {html.escape(on)} "
        f"{html.badge(_verdict(found), KINDS[standing(found)])}</h3>"
    )
    parts = [heading]
    if found.get("meaning"):
        parts.append(html.paragraph(sentence(found["meaning"])))
    if found.get("formula"):
        parts.append(f'<div class="formula-line">τ = {html.escape(found["formula"])}</div>')
    pictures = []
    signature = found.get("signature")
    if signature and signature.get("x"):
        shown = f"what the model leaves over {signature['coordinate']}, and the fitted effect"
        pictures.append(embed(signature_plot(signature, spoken(found["effect"])), shown))
    if found.get("blocks"):
        shown = "error of each block before and after"
        pictures.append(embed(before_after_plot(found["blocks"]), shown))
    parts.append(html.plots(pictures) if pictures else "")
    parts.append(_parameters(found))
    if others := found.get("ambiguous_with"):
        names = ", ".join(map(spoken, others))
        parts.append(html.paragraph(f"Could also be {names}: on this motion they agree."))
    if found.get("next_motion"):
        parts.append(html.paragraph(f"To be sure: {found['next_motion']}."))
    return f'<div class="finding">{"".join(parts)}</div>'


def _parameters(found: Mapping[str, Any]) -> str:
    rows = [
        [name, *(typeset(p.get(end)) for end in ("value", "low", "high")), p["unit"]]
        for name, p in found.get("parameters", {}).items()
    ]
    units = found.get("shape_units") or {}
    rows += [
        [name, str(value), DASH, DASH, units.get(name, "")]
        for name, value in (found.get("shape_words") or {}).items()
        if name not in found.get("parameters", {})
    ]
    return html.table(["parameter", "value", "5 %", "95 %", "unit"], rows) if rows else ""


def signature_plot(signature: Mapping[str, Any], effect: str) -> Plot:
    """Draw the mean residual with its band, and the effect as it was fitted."""
    x = signature["x"]
    many = "lines" if len(x) > 40 else "lines+markers"
    data = [
        band(x, signature["low"], signature["high"], RESIDUAL),
        line(
            x, signature["residual"], "what the model leaves", RESIDUAL, mode=many,
            marker={"size": 5},
        ),
        line(x, signature["effect"], effect, EFFECT, width=2.6),
    ]  # fmt: skip
    unit = f" [{signature['unit']}]" if signature.get("unit") else ""
    layout = {
        "xaxis": axis(f"{spoken(signature['coordinate'])}{unit}"),
        "yaxis": axis("torque [N·m]"),
        "showlegend": True,
        "hovermode": "x unified",
    }
    return Plot(data, layout, 330)


def before_after_plot(blocks: Sequence[Mapping[str, Any]]) -> Plot:
    """Draw two dots a block, joined: blue below grey is better, red above it is worse."""
    times = [block["time"] for block in blocks]
    joined_x, joined_y = [], []
    for block in blocks:
        joined_x += [block["time"], block["time"], None]
        joined_y += [block["before"], block["after"], None]
    better = [block["after"] <= block["before"] for block in blocks]
    hover = "%{y:.3g} N·m at %{x:.0f} s"
    data: list[dict[str, Any]] = [
        {
            "type": "scatter", "mode": "lines", "x": joined_x, "y": joined_y, "showlegend": False,
            "line": {"color": BEFORE, "width": 2}, "hoverinfo": "skip",
        },
        {
            "type": "scatter", "mode": "markers", "x": times, "name": "before",
            "y": [block["before"] for block in blocks], "marker": {"color": BEFORE, "size": 8},
            "hovertemplate": hover,
        },
        {
            "type": "scatter", "mode": "markers", "x": times, "name": "after",
            "y": [block["after"] for block in blocks], "hovertemplate": hover,
            "marker": {"color": [AFTER if good else BAD for good in better], "size": 9},
        },
    ]  # fmt: skip
    layout = {
        "xaxis": axis("time of the block [s]"),
        "yaxis": axis("RMS error [N·m]", rangemode="tozero"),
        "showlegend": True,
    }
    return Plot(data, layout, 330)
