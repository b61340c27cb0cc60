"""Layouts of PlotJuggler and Foxglove: the torques of a running robot, joint by joint."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

COLUMNS = 2
_WIDTH = 30.0  # s that a live plot shows


@dataclass(frozen=True)
class Signal:
    """A torque on a topic.

    Attributes:
        label: in the legend.
        topic: below the namespace.
        field: the array of the message.
        named: whether the message names its joints; otherwise they have the model's order.
        own: whether our nodes publish it, and so in the model's order.
    """

    label: str
    topic: str
    field: str
    colour: str
    named: bool = True
    own: bool = True


TORQUES = (
    Signal("measured", "joint_states", "effort", "#1f77b4", own=False),
    Signal("predicted", "monitor/predicted", "effort", "#d62728"),
    Signal("feedforward", "feedforward/feedforward", "effort", "#2ca02c"),
    Signal("commands", "feedforward/commands", "data", "#9467bd", named=False),
)
RESIDUAL = (Signal("residual", "monitor/residual", "effort", "#ff7f0e"),)
TABS = {"torque [N·m]": TORQUES, "residual [N·m]": RESIDUAL}


def plotjuggler(joints: Sequence[str], namespace: str = "") -> str:
    """Return the XML of a layout with a tab of torques and one of residuals.

    PlotJuggler finds a joint of a JointState by its name.
    """
    root = ElementTree.Element("root")
    window = _below(root, "tabbed_widget", parent="main_window", name="Main Window")
    for name, signals in TABS.items():
        tab = _below(window, "Tab", containers="1", tab_name=name)
        split = _split(_below(tab, "Container"), "-", -(-len(joints) // COLUMNS))
        for first in range(0, len(joints), COLUMNS):
            numbers = range(first, min(first + COLUMNS, len(joints)))
            row = _split(split, "|", len(numbers))
            for number in numbers:
                area = _below(row, "DockArea", name=joints[number])
                plot = _below(area, "plot", mode="TimeSeries", style="Lines", flip_x="false",
                              flip_y="false")  # fmt: skip
                for signal in signals:
                    by_name, by_place = (
                        f"{joints[number]}/{signal.field}",
                        f"{signal.field}[{number}]",
                    )
                    place = by_name if signal.named else by_place
                    curve = f"{_topic(signal, namespace)}/{place}"
                    _below(plot, "curve", name=curve, color=signal.colour)
    _below(window, "currentTabIndex", index="0")
    _below(root, "use_relative_time_offset", enabled="1")
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def foxglove(joints: Sequence[str], namespace: str = "") -> str:
    """Return the JSON of a layout with a plot of torques and one of residuals for each joint.

    Foxglove finds a joint by its place in the message. So it shows our own topics, which have the
    model's order; drivers publish joint states in an order of their own.
    """
    panels = dict(_panels(joints, namespace))
    names = list(panels)
    rows = [_tiled(names[k : k + len(TABS)], "row") for k in range(0, len(names), len(TABS))]
    layout = {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _tiled(rows, "column"),
    }
    return json.dumps(layout, indent=2, ensure_ascii=False) + "\n"


def _panels(joints: Sequence[str], namespace: str) -> Iterator[tuple[str, dict[str, object]]]:
    for number, joint in enumerate(joints):
        for title, signals in TABS.items():
            paths = [
                {
                    "value": f"{_topic(signal, namespace)}.{signal.field}[{number}]",
                    "label": signal.label,
                    "color": signal.colour,
                    "enabled": True,
                    "timestampMethod": "headerStamp" if signal.named else "receiveTime",
                }
                for signal in signals
                if signal.own
            ]
            yield (
                f"Plot!{title.split()[0]}{number}",
                {
                    "title": f"{joint}: {title}",
                    "foxglovePanelTitle": f"{joint}: {title}",
                    "paths": paths,
                    "showLegend": True,
                    "legendDisplay": "floating",
                    "showXAxisLabels": True,
                    "showYAxisLabels": True,
                    "isSynced": True,
                    "xAxisVal": "timestamp",
                    "followingViewWidth": _WIDTH,
                },
            )


def _tiled(parts: Sequence[object], direction: str) -> object:
    """Return the parts beside or below each other, of equal size: Foxglove divides in two."""
    if len(parts) == 1:
        return parts[0]
    return {
        "direction": direction,
        "first": parts[0],
        "second": _tiled(parts[1:], direction),
        "splitPercentage": 100.0 / len(parts),
    }


def _topic(signal: Signal, namespace: str) -> str:
    return "/" + "/".join(part for part in (namespace.strip("/"), signal.topic) if part)


def _below(parent: ElementTree.Element, tag: str, /, **attributes: str) -> ElementTree.Element:
    return ElementTree.SubElement(parent, tag, attributes)


def _split(parent: ElementTree.Element, orientation: str, count: int) -> ElementTree.Element:
    sizes = ";".join([f"{1.0 / count:.6g}"] * count)
    return _below(parent, "DockSplitter", orientation=orientation, count=str(count), sizes=sizes)
