"""Where the model fails: the regions that hold most of the error, and what the error follows."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.numbers import percent, typeset
from lagrangian_ff.report import html
from lagrangian_ff.report.colours import HEAT
from lagrangian_ff.report.page import Section
from lagrangian_ff.report.plot import Plot, axis, embed
from lagrangian_ff.words import sentence

LEAD = (
    "Parts of the motion that hold clearly more of a joint's error than of its time. A part is "
    "named only if error spread at random over the motion would hardly ever show one so striking."
)
ROW = 34
"""Height of a joint's row in a map, pixels."""
EVENLY = "No region stands out: the error is spread evenly over the motion."


def regions_section(record: Mapping[str, Any]) -> Section:
    """Return the regions of a comparison as bars, and the joints that have none."""
    regions, evenly = record["regions"], record["evenly"]
    rows = []
    for region in regions:
        error, time = region["share_of_error"], region["share_of_time"]
        bars = (f"{percent(error)} of its error", error), (f"{percent(time)} of the time", time)
        rows.append(html.Share(region["joint"], region["place"], bars))
    why = record["words"][0] if record["too_short"] else EVENLY
    body = html.shares(rows) if rows else html.paragraph(sentence(why))
    if rows and evenly:
        names = ", ".join(evenly)
        body += html.note(f"On {names} no region stands out: the error is spread evenly.")
    waves = _waves(record)
    body += html.bullets(waves) if waves else ""
    return Section("Where it fails", LEAD, body)


def _waves(record: Mapping[str, Any]) -> list[str]:
    # Not above: the page of a history needs none of the libraries of a diagnosis.
    from lagrangian_ff.diagnosis.where.orders import NAMED_SHARE

    return [
        f"{one['joint']}: the residual holds a wave over the joint's angle, "
        f"{one['lines'][0]['order']:.3g} to a turn, of {typeset(one['lines'][0]['amplitude'], 2)} "
        f"N·m ({percent(one['lines'][0]['share'])} of its error)."
        for one in record["spectra"]
        if one["lines"] and one["lines"][0]["share"] >= NAMED_SHARE
    ]


def dependence_section(record: Mapping[str, Any]) -> Section:
    """Return maps of what the error of a comparison depends on, and of when it was large."""
    follows = embed(
        dependence_plot(record["bins"]),
        "map of joints and coordinates: the share of the squared error that follows each",
        "How much of each joint's squared error would go if the model had the right function of "
        "this one quantity. What chance alone would give is taken off. A dark field is a lead: an "
        "effect that depends on this quantity is missing or wrong.",
    )
    when = embed(
        blocks_plot(record),
        "map of joints and time: the error of each 3 seconds relative to the joint's usual error",
        "Error of each 3 s relative to the joint's RMS error; pale is none, dark three times the "
        "usual.",
    )
    return Section(
        "What the error follows",
        "Each joint's error, against everything that is known of the motion.",
        f'{follows}<h3 class="plain">When it was large</h3>{when}',
    )


def dependence_plot(bins: Sequence[Mapping[str, Any]]) -> Plot:
    """Draw how much of each joint's squared error a function of one coordinate would remove."""
    joints = list(dict.fromkeys(one["joint"] for one in bins))
    labels = dict.fromkeys((one["coordinate"], one["label"]) for one in bins)
    found = {(one["joint"], one["coordinate"]): 100.0 * one["explained"] for one in bins}
    values = [[found.get((joint, name)) for name, _ in labels] for joint in joints]
    return _map(
        [_wrapped(label) for _, label in labels], joints, values,
        "%{y}: %{z:.0f} % of its squared error<br>follows %{x}<extra></extra>",
        [[_text(value) for value in row] for row in values], top=60.0,
    )  # fmt: skip


def blocks_plot(record: Mapping[str, Any]) -> Plot:
    """Draw the error of each joint in each block of time, relative to its usual error."""
    blocks, joints = record["blocks"], list(record["joints"])
    values = [
        [
            block["joints"][joint] / usual if (usual := record["joints"][joint]["rmse"]) else None
            for block in blocks
        ]
        for joint in joints
    ]
    middles = [0.5 * (block["begin"] + block["end"]) for block in blocks]
    plot = _map(
        middles, joints, values,
        "%{y} at %{x:.0f} s: %{z:.2g} × its rms error<extra></extra>", None, top=3.0,
    )  # fmt: skip
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
    trace: dict[str, Any] = {
        "type": "heatmap", "x": list(columns), "y": list(joints), "z": values,
        "colorscale": [list(stop) for stop in HEAT], "zmin": 0.0, "zmax": top,
        "showscale": False, "hovertemplate": hover, "xgap": 2, "ygap": 2, "hoverongaps": False,
    }  # fmt: skip
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
        range(1, len(words)),
        key=lambda k: max(len(" ".join(words[:k])), len(" ".join(words[k:]))),
    )
    return f"{' '.join(words[:cut])}<br>{' '.join(words[cut:])}"
