"""Where the model fails: the regions that hold most of the error, and what the error follows."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from lagrangian_ff.numbers import percent, typeset
from lagrangian_ff.report import html
from lagrangian_ff.report.colours import HEAT
from lagrangian_ff.report.page import Section
from lagrangian_ff.report.plot import Plot, Trace, axis, embed
from lagrangian_ff.words import sentence

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis.where import Bins, Localisation

LEAD = (
    "Parts of the motion that hold clearly more of a joint's error than of its time. A part is "
    "named only if error spread at random over the motion would hardly ever show one so striking."
)
ROW = 34
"""Height of a joint's row in a map, pixels."""
EVENLY = "No region stands out: the error is spread evenly over the motion."


def regions_section(where: "Localisation") -> Section:
    """Return the regions as bars, and the joints that have none."""
    rows = []
    for region in where.regions:
        error, time = region.share_of_error, region.share_of_time
        bars = (f"{percent(error)} of its error", error), (f"{percent(time)} of the time", time)
        rows.append(html.Share(region.joint, region.place, bars))
    why = where.words()[0] if where.series.too_short else EVENLY
    body = html.shares(rows) if rows else html.paragraph(sentence(why))
    if rows and where.evenly:
        names = ", ".join(where.evenly)
        body += html.note(f"On {names} no region stands out: the error is spread evenly.")
    waves = [
        f"{one.joint}: the residual holds a wave over the joint's angle, "
        f"{line.order:.3g} to a turn, of {typeset(line.amplitude, 2)} "
        f"N·m ({percent(one.share(line))} of its error)."
        for one in where.spectra
        if (line := one.named)
    ]
    body += html.bullets(waves) if waves else ""
    return Section("Where it fails", LEAD, body)


def dependence_section(where: "Localisation") -> Section:
    """Return maps of what the error depends on, and of when it was large."""
    follows = embed(
        dependence_plot(where.bins),
        "map of joints and coordinates: the share of the squared error that follows each",
        "How much of each joint's squared error would go if the model had the right function of "
        "this one quantity. What chance alone would give is taken off. A dark field is a lead: an "
        "effect that depends on this quantity is missing or wrong.",
    )
    when = embed(
        blocks_plot(where),
        "map of joints and time: the error of each 3 seconds relative to the joint's usual error",
        "Error of each 3 s relative to the joint's RMS error; pale is none, dark three times the "
        "usual.",
    )
    return Section(
        "What the error follows",
        "Each joint's error, against everything that is known of the motion.",
        f'{follows}<h3 class="plain">When it was large</h3>{when}',
    )


def dependence_plot(bins: Sequence["Bins"]) -> Plot:
    """Draw how much of each joint's squared error a function of one coordinate would remove."""
    joints = list(dict.fromkeys(one.joint for one in bins))
    labels = {one.coordinate.name: one.coordinate.label for one in bins}
    found = {(one.joint, one.coordinate.name): 100.0 * one.explained for one in bins}
    values = [[found.get((joint, name)) for name in labels] for joint in joints]
    hover = "%{y}: %{z:.0f} % of its squared error<br>follows %{x}<extra></extra>"
    shown = [[_text(value) for value in row] for row in values]
    return _map([_wrapped(one) for one in labels.values()], joints, values, hover, shown, top=60.0)


def blocks_plot(where: "Localisation") -> Plot:
    """Draw the error of each joint in each block of time, relative to its usual error."""
    usual, blocks = where.comparison.score.by_joint, where.blocks
    values = [
        [block.joints[name] / rmse if rmse else None for block in blocks]
        for name, rmse in usual.items()
    ]
    middles = [0.5 * (block.begin + block.end) for block in blocks]
    hover = "%{y} at %{x:.0f} s: %{z:.2g} × its rms error<extra></extra>"
    plot = _map(middles, list(usual), values, hover, None, top=3.0)
    layout = {**plot.layout, "xaxis": axis("time [s]", showgrid=False)}
    return Plot(plot.data, layout, plot.height + 20)


def _map(
    columns: Sequence[Any],
    joints: Sequence[str],
    values: Sequence[Sequence[float | None]],
    hover: str,
    text: Sequence[Sequence[str]] | None,
    top: float,
) -> Plot:
    trace: Trace = {"type": "heatmap", "x": list(columns), "y": list(joints), "z": values}
    trace |= {"colorscale": [list(stop) for stop in HEAT], "zmin": 0.0, "zmax": top}
    trace |= {"showscale": False, "xgap": 2, "ygap": 2, "hoverongaps": False}
    trace["hovertemplate"] = hover
    if text is not None:
        trace |= {"text": text, "texttemplate": "%{text}", "textfont": {"size": 12}}
    layout = {
        "xaxis": axis(side="top" if text is not None else "bottom", showgrid=False),
        "yaxis": axis(autorange="reversed", showgrid=False),
        "margin": {"l": 70, "r": 10, "t": 10, "b": 10},
    }
    return Plot([trace], layout, 70 + ROW * len(joints))


def _text(value: float | None) -> str:
    return "" if value is None or value < 0.5 else f"{value:.0f} %"


def _wrapped(label: str) -> str:
    """Return a label in at most two lines."""
    words = label.split()
    if len(label) <= 12 or len(words) == 1:
        return label
    cut = min(
        range(1, len(words)), key=lambda k: max(len(" ".join(words[:k])), len(" ".join(words[k:])))
    )
    return f"{' '.join(words[:cut])}<br>{' '.join(words[cut:])}"
