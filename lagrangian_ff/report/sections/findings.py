"""Which effects are missing: at a glance, the evidence for each, and how the error falls."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from lagrangian_ff.numbers import DASH, chance, percent, typeset
from lagrangian_ff.report import html
from lagrangian_ff.report.colours import AFTER, BAD, BEFORE, EFFECT, RESIDUAL
from lagrangian_ff.report.page import Section
from lagrangian_ff.report.plot import Plot, axis, band, embed, line
from lagrangian_ff.report.sections.history import fall_plot
from lagrangian_ff.words import sentence, spoken

if TYPE_CHECKING:
    # The page of a history needs none of the libraries of a diagnosis.
    from lagrangian_ff.diagnosis import DiagnosisRun
    from lagrangian_ff.diagnosis.consequence import Consequence
    from lagrangian_ff.diagnosis.results import Diagnosis, Found, PartialResidual

MEANINGS = (
    "Confirmed: the effect, frozen as it was found, also lowers the error on data that the search "
    "did not see. Suggested: the evidence is strong, the confirmation is not. Ambiguous: another "
    "effect would explain this motion as well. Only what is confirmed should be added without a "
    "second look."
)


def summary_section(run: "DiagnosisRun") -> Section:
    """Return a card for each finding that matters, and a table of all."""
    findings, every = run.diagnosis.found, run.diagnosis.model.joints
    if not findings:
        return Section(
            "What is missing",
            "",
            html.paragraph("No effect of the catalogue earned its place on these recordings."),
        )
    cards = [_card(one, every) for one in findings[:3]]
    rows = [
        [
            spoken(one.effect.name),
            one.place(every),
            _verdict(one),
            *map(typeset, (*one.errors, one.log_bayes_factor)),
            chance(one.p_value, DASH),
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


def evidence_section(diagnosis: "Diagnosis") -> Section | None:
    """Return for each finding what it is, where it shows, its size, and whether it helps."""
    findings, every = diagnosis.found, diagnosis.model.joints
    if not findings:
        return None
    return Section(
        "The evidence",
        "Left: what the model leaves, over the quantity in which the effect shows, and the effect "
        "as fitted. Right: the error of each block of held-back motion before and after.",
        "".join(evidence(one, every) for one in findings),
    )


def fall_section(run: "DiagnosisRun") -> Section | None:
    """Return the error after each addition; None if nothing was confirmed and tried."""
    tried = run.tried
    if not tried:
        return None
    names = ["as it was", *(f"+ {finding.name}" for finding, _ in tried)]
    errors = [tried[0][1].every_before, *(made.every_after for _, made in tried)]
    small = html.note(f"{percent(errors[-1] / errors[0])} of the first error is left.")
    return Section(
        "The error falls",
        "One effect at a time, each chosen with the ones before it in the model, judged on data "
        "that took no part in the choice.",
        embed(fall_plot(names, errors), "error on held-back data after each step") + small,
    )


def _verdict(found: "Found") -> str:
    others = ", ".join(map(spoken, found.rivals))
    rivals = "" if found.confirmed or found.doubt else f" with {others}"
    return f"{found.verdict.value}{rivals}"


def _card(found: "Found", every: Sequence[str]) -> html.Card:
    (before, after), on = found.errors, found.place(every)
    if before is None or after is None or not before > 0.0 or not math.isfinite(after / before):
        return html.Card(spoken(found.effect.name), f"on {on}", _verdict(found))
    fall = 1.0 - after / before
    made = found.consequence
    of = f" of {made.joint}" if made is not None and len(found.joints) > 1 else ""
    # An error that rises is said as such, never as a negative fall.
    change = f"error{of} {percent(abs(fall))} {'lower' if fall >= 0.0 else 'higher'}"
    return html.Card(
        spoken(found.effect.name),
        f"on {on}: {change} on held-back data",
        f"{typeset(before)} → {typeset(after)} N·m, {_verdict(found)}",
        True if found.confirmed else None,
    )


def evidence(found: "Found", every: Sequence[str], meaning: str = "") -> str:
    """Return what a finding is, where it shows, its size, and whether it helps, as HTML.

    Args:
        every: the joints of the model.  meaning: in words; by default that of the effect.
    """
    effect, residual = found.effect, found.partial_residual
    name, badge = spoken(effect.name), "good" if found.confirmed else "fair"
    parts = [
        f"<h3>{html.escape(name)} on {html.escape(found.place(every))} "
        f"{html.badge(_verdict(found), badge)}</h3>"
    ]
    if words := meaning or effect.meaning:
        parts.append(html.paragraph(sentence(words)))
    parts.append(f'<div class="formula-line">τ = {html.escape(effect.formula)}</div>')
    pictures = []
    if residual is not None and len(residual.x):
        shown = f"what the model leaves over {residual.coordinate}, and the fitted effect"
        pictures.append(embed(partial_residual_plot(residual, name), shown))
    if found.consequence is not None:
        of = found.consequence.joint
        shown = f"error of {of} in each block before and after"
        pictures.append(embed(before_after_plot(found.consequence), shown))
    parts.append(html.plots(pictures) if pictures else "")
    parts.append(_parameters(found, every))
    if found.rivals:
        names = ", ".join(map(spoken, found.rivals))
        parts.append(html.paragraph(f"Could also be {names}: on this motion they agree."))
    if effect.next_motion:
        parts.append(html.paragraph(f"To be sure: {effect.next_motion}."))
    return f'<div class="finding">{"".join(parts)}</div>'


def _parameters(found: "Found", every: Sequence[str]) -> str:
    rows = [
        [name, *map(typeset, (one.value, one.low, one.high)), one.unit]
        for name, one in found.parameters.items()
    ]
    units = {shape.name: shape.unit for shape in found.effect.shapes}
    rows += [
        [name, value, DASH, DASH, units[name]]
        for name, value in found.effect.shape_words(found.shape, every).items()
        if name not in found.parameters
    ]
    return html.table(["parameter", "value", "5 %", "95 %", "unit"], rows)


def partial_residual_plot(residual: "PartialResidual", effect: str) -> Plot:
    """Draw the mean residual with its band, and the effect as it was fitted."""
    x = residual.x.tolist()
    left = line(
        x,
        residual.residual.tolist(),
        "what the model leaves",
        RESIDUAL,
        mode="lines" if len(x) > 40 else "lines+markers",
        marker={"size": 5},
    )
    data = [
        band(x, residual.low.tolist(), residual.high.tolist(), RESIDUAL),
        left,
        line(x, residual.effect.tolist(), effect, EFFECT, width=2.6),
    ]
    unit = f" [{residual.unit}]" if residual.unit else ""
    layout = {
        "xaxis": axis(f"{spoken(residual.coordinate)}{unit}"),
        "yaxis": axis("torque [N·m]"),
        "showlegend": True,
        "hovermode": "x unified",
    }
    return Plot(data, layout, 330)


def before_after_plot(made: "Consequence") -> Plot:
    """Draw two dots a block, joined: blue below grey is better, red above it is worse."""
    times, before, after = made.time.tolist(), made.before.tolist(), made.after.tolist()
    joined_x, joined_y = [], []
    for time, *ends in zip(times, before, after, strict=True):
        joined_x += [time, time, None]
        joined_y += [*ends, None]
    colours = [AFTER if b >= a else BAD for b, a in zip(before, after, strict=True)]
    joined = {"type": "scatter", "mode": "lines", "x": joined_x, "y": joined_y}
    hover = "%{y:.3g} N·m at %{x:.0f} s"
    dots = {"type": "scatter", "mode": "markers", "x": times, "hovertemplate": hover}
    grey = {"color": BEFORE, "width": 2}
    data: list[dict[str, Any]] = [
        {**joined, "showlegend": False, "line": grey, "hoverinfo": "skip"},
        {**dots, "name": "before", "y": before, "marker": {"color": BEFORE, "size": 8}},
        {**dots, "name": "after", "y": after, "marker": {"color": colours, "size": 9}},
    ]
    layout = {
        "xaxis": axis("time of the block [s]"),
        "yaxis": axis("RMS error [N·m]", rangemode="tozero"),
        "showlegend": True,
    }
    return Plot(data, layout, 330)
