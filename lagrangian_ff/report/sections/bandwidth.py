"""The spectra behind the bandwidth that was chosen."""

from typing import TYPE_CHECKING

import numpy as np

from lagrangian_ff.numbers import percent
from lagrangian_ff.report import html
from lagrangian_ff.report.colours import INK, MEASURED, PREDICTED, RESIDUAL
from lagrangian_ff.report.page import Section
from lagrangian_ff.report.plot import Plot, axis, embed, line
from lagrangian_ff.words import sentence

if TYPE_CHECKING:
    from lagrangian_ff.recording import Bandwidth

NOTE = (
    "Grey: the measured torque. Blue: the part of it that a regression on the motion predicts in "
    "stretches it has not seen. Orange: what noise adds, that of the torque and that of the "
    "acceleration, which is differentiated twice and grows steeply. The dashed line is the "
    "bandwidth: what lies right of it is filtered out."
)


def bandwidth_section(found: "Bandwidth") -> Section:
    """Return why the bandwidth is what it is, with the spectrum of every joint's torque."""
    lead = (
        f"{sentence(found.reason)} Position and torque of all joints pass the same low-pass, so "
        "that they stay in step. --bandwidth HZ sets another."
    )
    figures = [
        embed(spectrum_plot(found, n), f"spectrum of the torque of {joint}")
        for n, joint in enumerate(found.joints)
    ]
    body = html.plots(figures) + html.note(NOTE) if figures else ""
    return Section("Where torque and motion lose coherence", lead, body)


def spectrum_plot(found: "Bandwidth", n: int) -> Plot:
    """Draw the amplitude of one joint's torque over frequency, and the bandwidth."""
    middle = 0.5 * (found.edges[1:] + found.edges[:-1])
    scale = float(found.torque[:, n].max())
    low = 1e-5 * scale
    hover = "%{x:.3g} Hz: %{y:.2g} N·m/√Hz<extra></extra>"

    def curve(values: "np.ndarray", name: str, colour: str, width: float) -> dict[str, object]:
        shown = [float(v) if v > low else None for v in values]
        return line(middle.tolist(), shown, name, colour, width=width, hovertemplate=hover)

    data = [
        curve(found.torque[:, n], "measured", MEASURED, 3.0),
        curve(found.related[:, n], "explained by the motion", PREDICTED, 1.8),
        curve(found.noise[:, n], "noise", RESIDUAL, 1.8),
    ]
    mark = {"type": "line", "x0": found.hertz, "x1": found.hertz, "yref": "paper", "y0": 0, "y1": 1}
    width = np.diff(found.edges)
    above = middle > found.hertz
    torque, related = (found.torque[:, n] ** 2 * width, found.related[:, n] ** 2 * width)
    lost = float(1.0 - related[above].sum() / torque[above].sum()) if above.any() else 0.0
    words = f"<b>{found.joints[n]}</b>"
    if above.any():
        words += f"  {percent(lost)} above {found.hertz:g} Hz is unrelated"
    title = {"text": words, "font": {"size": 12}, "pad": {"l": 8, "t": 4}}
    corner = {"xref": "container", "x": 0, "xanchor": "left", "y": 1, "yanchor": "top"}
    span = [np.log10(max(low, 0.5 * float(found.torque[:, n].min()))), np.log10(2.0 * scale)]
    ticks = [one for one in (0.5, 1, 2, 5, 10, 20, 40) if middle[0] <= one <= found.edges[-1]]
    layout = {
        "title": {**title, **corner},
        "xaxis": axis(
            "frequency [Hz]", type="log", tickvals=ticks, ticktext=[f"{one:g}" for one in ticks]
        ),
        "yaxis": axis("N·m/√Hz", type="log", range=span, exponentformat="power", dtick=1),
        "shapes": [{**mark, "line": {"color": INK, "width": 1.2, "dash": "dash"}}],
        "margin": {"l": 62, "r": 14, "t": 36, "b": 44},
    }  # fmt: skip
    return Plot(data, layout, 300)
