"""Which effects are missing: what was found at a glance, then the evidence for each."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.report import html
from lagrangian_ff.report.interactive import embed
from lagrangian_ff.report.interactive.before_after import before_after_plot
from lagrangian_ff.report.interactive.signature import signature_plot
from lagrangian_ff.report.numbers import number, percent
from lagrangian_ff.report.section import Section
from lagrangian_ff.report.words import chance, sentence, spoken
from lagrangian_ff.words import where

KINDS = {"confirmed": "good", "suggested": "fair", "ambiguous": "fair", "unexplained": "bad"}
"""The colour of each verdict."""
MEANINGS = (
    "Confirmed: the effect, frozen as it was found, also lowers the error on data that the search "
    "did not see. Suggested: the evidence is strong, the confirmation is not. Ambiguous: another "
    "effect would explain this motion as well. Only what is confirmed should be added without a "
    "second look."
)


def summary_section(record: Mapping[str, Any]) -> Section:
    """A card for each finding that matters, and a table of all.

    Args:
        record: of diagnose.
    """
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
            one["verdict"],
            number(_value(one, "error_before")),
            number(_value(one, "error_after")),
            number(_value(one, "evidence_gain")),
            chance(one.get("p_value")),
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
    """For each finding what it is, where it shows, its size, and whether it helps.

    Args:
        record: of diagnose.
    """
    if not record["findings"]:
        return None
    return Section(
        "The evidence",
        "Left: what the model leaves, over the quantity in which the effect shows, and the effect "
        "as fitted. Right: the error of each block of held-back motion before and after.",
        "".join(_finding(one, record.get("joints", ())) for one in record["findings"]),
    )


def _card(found: Mapping[str, Any], every: Sequence[str]) -> html.Card:
    before, after = _value(found, "error_before"), _value(found, "error_after")
    on = where(found, every)
    if not (math.isfinite(before) and math.isfinite(after) and before > 0.0):
        return html.Card(spoken(found["effect"]), f"on {on}", found["verdict"])
    fall = 1.0 - after / before
    # An error that rises is said as such, never as a negative fall.
    change = f"error {percent(abs(fall))} {'lower' if fall >= 0.0 else 'higher'}"
    return html.Card(
        spoken(found["effect"]),
        f"on {on}: {change} on held-back data",
        f"{number(before)} → {number(after)} N·m, {found['verdict']}",
        True if found["verdict"] == "confirmed" else None,
    )


def _finding(found: Mapping[str, Any], every: Sequence[str]) -> str:
    on = where(found, every)
    heading = (
        f"<h3>{html.escape(spoken(found['effect']))} on {html.escape(on)} "
        f"{html.badge(found['verdict'], KINDS.get(found['verdict'].split()[0], ''))}</h3>"
    )
    parts = [heading]
    if found.get("meaning"):
        parts.append(html.paragraph(sentence(found["meaning"])))
    if found.get("formula"):
        parts.append(f'<div class="formula-line">τ = {html.escape(found["formula"])}</div>')
    pictures = []
    signature = found.get("signature")
    if signature and signature.get("x"):
        pictures.append(
            embed(
                signature_plot(signature, spoken(found["effect"])),
                f"what the model leaves over {signature['coordinate']}, and the fitted effect",
            )
        )
    if found.get("blocks"):
        pictures.append(
            embed(before_after_plot(found["blocks"]), "error of each block before and after")
        )
    parts.append(html.plots(pictures) if pictures else "")
    parts.append(_parameters(found))
    if look_alikes := names_of(found.get("ambiguous_with") or []):
        parts.append(
            html.paragraph(f"Could also be {', '.join(look_alikes)}: on this motion they agree.")
        )
    if found.get("next_motion"):
        parts.append(html.paragraph(f"To be sure: {found['next_motion']}."))
    return f'<div class="finding">{"".join(parts)}</div>'


def _parameters(found: Mapping[str, Any]) -> str:
    rows = [
        [name, number(p["value"]), number(_value(p, "low")), number(_value(p, "high")), p["unit"]]
        for name, p in found.get("parameters", {}).items()
    ]
    units = found.get("shape_units") or {}
    rows += [
        [name, str(value), "–", "–", units.get(name, "")]
        for name, value in (found.get("shape_words") or {}).items()
        if name not in found.get("parameters", {})
    ]
    return html.table(["parameter", "value", "5 %", "95 %", "unit"], rows) if rows else ""


def names_of(others: Sequence[Any]) -> list[str]:
    """Effects given by name, or as records with a joint."""
    names = []
    for one in others:
        if isinstance(one, Mapping):
            joints = one.get("joints") or ([one["joint"]] if one.get("joint") else [])
            place = f" on {', '.join(joints)}" if joints else ""
            names.append(f"{spoken(one['effect'])}{place}")
        else:
            names.append(spoken(str(one)))
    return names


def _value(record: Mapping[str, Any], name: str) -> float:
    value = record.get(name)
    return math.nan if value is None else float(value)
