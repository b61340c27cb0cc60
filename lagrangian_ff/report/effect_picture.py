"""A picture of one effect: its torque over what it depends on, and over time."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import Effect, Inputs
from lagrangian_ff.effects.gear import Gear
from lagrangian_ff.effects.reversals import since_reversal
from lagrangian_ff.kernels import States
from lagrangian_ff.numbers import typeset
from lagrangian_ff.report.colours import FAINT, FRAME, INK, PREDICTED, RESIDUAL
from lagrangian_ff.report.style import legend_above, new_figure, styled, symmetric

JOINT = 1
"""The joint that is drawn; its neighbours may take part in the effect."""
RATE, SECONDS = 250.0, 40.0
HEIGHTS = (2.0, 1.2, 0.8, 0.6)
"""N·m, the largest torque that each column in turn adds."""
WINDOW = (5.0, 17.0)
"""s, shown of effects that do not depend on time; slow, then fast."""
SOON = 0.6
"""s after a reversal that are shown."""
HIGHEST_ORDER = 14
JERK = 3.0
"""N·m, for effects that a smooth motion hardly shows."""
LONG = 60  # characters of a formula that need a second line
SPEEDS = (0.5, 1.1, 1.9)
"""rad/s, the pace of each joint."""


def signature_figure(effect: Effect) -> Figure:
    """Draw the torque of one effect along a made-up motion of three joints.

    On the left over the coordinate that shows it, both directions of motion apart; on the right
    over time, above the joint's speed. What shows over time is drawn over time alone. Parameters
    are chosen for a torque of about 2 N·m; shapes are those that a search starts at.
    """
    shape = {s.name: s.start for s in effect.shapes}
    if isinstance(effect, Gear):
        shape["of"] = float(JOINT)
    x = motion(JERK if effect.rings else 0.0)
    columns = effect.columns(x, JOINT, shape)
    parameters = _parameters(columns)
    if isinstance(effect, Gear):
        parameters[1:] = 0.0  # the made-up load lacks nothing
    torque = columns @ parameters
    with styled():
        figure = new_figure(4.3)
        wide = effect.coordinate == "time"
        grid = figure.add_gridspec(2, 1 if wide else 2, height_ratios=(3, 1))
        right = figure.add_subplot(grid[0, -1])
        speed = figure.add_subplot(grid[1, -1], sharex=right)
        _over_time(right, speed, effect, x, torque)
        said = _numbers(effect, parameters, shape)
        if wide:
            right.set_title(f"{effect.formula}    {said}")
        else:
            right.set_title(said, fontweight="normal")
            left = figure.add_subplot(grid[:, 0])
            draw = _spectrum if effect.coordinate == "order" else _over_coordinate
            draw(left, effect, x, torque)
            left.set_title(_formula(effect))
        legend_above(figure, *right.get_legend_handles_labels())
        figure.text(0.995, 0.985, effect.name, ha="right", va="top", fontsize=11.0, color=INK)
    return figure


def motion(jerk: float = 0.0) -> Inputs:
    """Return a swing through the whole turn that creeps first and is fast then, under load.

    Args:
        jerk: N·m, by which the load jumps at reversals, as a part that tips over does.
    """
    time = np.arange(round(SECONDS * RATE)) / RATE
    rise = 1.0 / (1.0 + np.exp(-(time - 9.0) / 0.5))
    phase = (0.12 * time + 0.88 * 0.5 * np.logaddexp(0.0, (time - 9.0) / 0.5))[:, None]
    pace = (0.12 + 0.88 * rise)[:, None]
    change = (0.88 * rise * (1.0 - rise) / 0.5)[:, None]
    q, slope, bend = np.zeros((3, time.size, len(SPEEDS)))
    for size, times, begin in ((2.7, 1.0, 0.6), (0.3, 2.7, 1.0)):
        omega = times * np.array(SPEEDS)
        q += size * np.sin(omega * phase + begin)
        slope += size * omega * np.cos(omega * phase + begin)
        bend -= size * omega**2 * np.sin(omega * phase + begin)
    qd, qdd = slope * pace, bend * pace**2 + slope * change
    load = 1.5 * qdd + 11.0 * np.sin(q + 0.4)
    load += jerk * np.tanh(qd / 0.02)
    torque = load + 1.0 * qd + 2.0 * np.tanh(qd / 0.02)
    warm = 20.0 + 0.5 * time[:, None] * np.ones(len(SPEEDS))
    states = States.of(q, qd, qdd)
    return Inputs.of(states, time=time, load=load, torque=torque, temperature=warm)


def _formula(effect: Effect) -> str:
    first, plus, second = effect.formula.partition(") + ")
    return f"{first})\n+ {second}" if plus and len(effect.formula) > LONG else effect.formula


def _parameters(columns: Floats) -> Floats:
    """Return parameters of two digits each, so that the title says what is drawn."""
    largest = np.abs(columns).max(axis=0)
    wanted = np.resize(HEIGHTS, columns.shape[1])
    found = np.divide(wanted, largest, out=np.zeros_like(largest), where=largest > 0.0)
    return np.asarray([float(f"{value:.2g}") for value in found])


def _over_coordinate(axes: Axes, effect: Effect, x: Inputs, torque: Floats) -> None:
    label, values = _coordinate(effect, x)
    forward = x.qd[:, JOINT] >= 0.0
    near = values <= (SOON if effect.coordinate == "since_reversal" else np.inf)
    for there, colour in ((forward, PREDICTED), (~forward, RESIDUAL)):
        at, shown = values[there & near], torque[there & near]
        axes.plot(at, shown, "o", markersize=1.6, markeredgewidth=0.0, color=colour)
    axes.axhline(0.0, color=FAINT, linewidth=0.6)
    symmetric(axes, float(np.abs(torque).max()))
    axes.set_xlabel(label)
    axes.set_ylabel("torque [N·m]")


def _coordinate(effect: Effect, x: Inputs) -> tuple[str, Floats]:
    """Return the label and the values (M,) of the coordinate that shows an effect."""
    if effect.coordinate == "since_reversal":
        since = since_reversal(x.time, x.qd[:, JOINT], x.segment)
        return "time since the last reversal [s]", since
    known = {
        "position": ("position [rad]", x.q),
        "acceleration": ("acceleration [rad/s²]", x.qdd),
        "load": ("load torque [N·m]", x.load),
    }
    label, values = known.get(effect.coordinate, ("speed [rad/s]", x.qd))
    return label, values[:, JOINT]


def _spectrum(axes: Axes, effect: Effect, x: Inputs, torque: Floats) -> None:
    """Draw the amplitude of each order over the joint's angle, all fitted at once."""
    orders = np.arange(1, HIGHEST_ORDER + 1)
    angle = np.outer(x.q[:, JOINT], orders)
    design = np.hstack([np.ones((len(x), 1)), np.cos(angle), np.sin(angle)])
    found = np.linalg.lstsq(design, torque, rcond=None)[0][1:].reshape(2, -1)
    axes.bar(orders, np.hypot(*found), 0.5, color=PREDICTED)
    axes.set_xticks(orders)
    axes.grid(visible=False, axis="x")
    axes.set_xlabel("order [periods in a turn of the joint]")
    axes.set_ylabel("amplitude [N·m]")


def _over_time(axes: Axes, below: Axes, effect: Effect, x: Inputs, torque: Floats) -> None:
    begin, end = (0.0, SECONDS) if effect.coordinate == "time" else WINDOW
    shown = (x.time >= begin) & (x.time <= end)
    time, speed = x.time[shown], x.qd[shown, JOINT]
    forward = speed >= 0.0
    axes.plot(time, torque[shown], color=FRAME, linewidth=0.8)
    for there, colour, label in (
        (forward, PREDICTED, "moving forwards"),
        (~forward, RESIDUAL, "moving backwards"),
    ):
        axes.plot(time, np.where(there, torque[shown], np.nan), color=colour, label=label)
    axes.axhline(0.0, color=FAINT, linewidth=0.6)
    symmetric(axes, float(np.abs(torque).max()))
    axes.tick_params(labelbottom=False)
    axes.set_ylabel("torque [N·m]")
    below.plot(time, speed, color=INK, linewidth=0.9)
    below.axhline(0.0, color=FAINT, linewidth=0.6)
    symmetric(below, float(np.abs(speed).max()))
    below.set_xlim(begin, end)
    below.set_xlabel("time [s]")
    below.set_ylabel("rad/s")


def _numbers(effect: Effect, parameters: Floats, shape: Mapping[str, float]) -> str:
    """Return the numbers that were chosen, named as in the formula."""
    said = [
        f"{p.name} = {typeset(float(value), 2)} {p.unit}".removesuffix(" 1")
        for p, value in zip(effect.parameters, parameters, strict=True)
    ]
    said += [f"{s.name} = {shape[s.name]:g} {s.unit}".removesuffix(" 1") for s in effect.shapes]
    return ",  ".join(said)
