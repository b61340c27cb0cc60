"""The section on changes since the identification: each change, its size and its evidence."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from lagrangian_ff.numbers import DASH, chance, typeset
from lagrangian_ff.report import html
from lagrangian_ff.report.colours import EFFECT, FAINT
from lagrangian_ff.report.page import Section
from lagrangian_ff.report.plot import Plot, axis, embed
from lagrangian_ff.words import spoken, which

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis import Changed, DiagnosisRun

LEAD = (
    "The recording against the data that the model was identified from: what stands out in the "
    "recording only has changed in between."
)
MASSES = "other masses: a load was attached or taken off"
"""What a change without parameters means."""


def changed_section(run: "DiagnosisRun") -> Section | None:
    """Return the changes that a diagnosis found, or that there are none; None if not asked."""
    changed, every = run.changed, run.diagnosis.model.joints
    if changed is None:
        return None
    title = "What changed since the identification"
    if not changed:
        same = "Nothing stands out: the arm is as it was when the model was identified."
        return Section(title, LEAD, html.paragraph(same))
    rows = [
        [
            spoken(one.what),
            which(one.joints, every),
            by,
            ends,
            typeset(one.size),
            typeset(one.log_bayes_factor),
            chance(one.p_value, DASH),
        ]
        for one in changed
        for by, ends in _amounts(one)
    ]
    header = ["what", "joint", "changed by", "90 % interval", "torque [N·m]", "gain", "p"]
    alike = [
        f"{_name(one, every)}: on this motion {' or '.join(map(spoken, one.rivals))} would "
        "explain as much."
        for one in changed
        if one.rivals
    ]
    alike += [f"{_name(one, every)}: {one.note}." for one in changed if one.note]
    small = html.note(
        "Torque is the RMS torque of the change. Gain is in log evidence: by how much the change "
        "makes the measured torques more likely. p is how often chance alone gives as much."
    )
    return Section(
        title,
        LEAD,
        html.table(header, rows, words=4, strong=2)
        + (html.bullets(alike) if alike else "")
        + embed(changes_plot(changed, every), "torque of each change, N·m rms")
        + small,
    )


def changes_plot(changed: "Sequence[Changed]", every: Sequence[str]) -> Plot:
    """Draw the torque of each change as a bar."""
    bars = {
        "type": "bar",
        "orientation": "h",
        "x": [one.size for one in changed],
        "y": [_name(one, every) for one in changed],
        "marker": {"color": EFFECT},
        "width": 0.6,
        "hovertemplate": "%{y}: %{x:.3g} N·m<extra></extra>",
    }
    layout = {
        "xaxis": axis("torque of the change, rms [N·m]", rangemode="tozero"),
        "yaxis": axis(autorange="reversed", showgrid=False, tickfont={"size": 12, "color": FAINT}),
        "margin": {"l": 150, "r": 14, "t": 10, "b": 44},
    }
    return Plot([bars], layout, 80 + 34 * len(changed))


def _amounts(changed: "Changed") -> list[tuple[str, str]]:
    """Return by how much each parameter changed, and between which values that lies."""
    return [
        (
            f"{name} {'+' if one.value > 0.0 else ''}{typeset(one.value)} {one.unit}",
            f"{typeset(one.low)} … {typeset(one.high)}" if one.bounded else DASH,
        )
        for name, one in changed.parameters.items()
    ] or [(MASSES, DASH)]


def _name(one: "Changed", every: Sequence[str]) -> str:
    return f"{spoken(one.what)} on {which(one.joints, every)}"
