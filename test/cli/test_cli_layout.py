"""`layout` on the command line: what the tools that ROS users look with are to show."""

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from cli_examples import JOINTS, assert_refused, lagrangian_ff, small_model


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return small_model(tmp_path_factory.mktemp("layout") / "model.npz")


def plots(layout: Path) -> dict[str, dict[str, list[str]]]:
    """Return the curves by tab and joint of a layout of PlotJuggler."""
    found: dict[str, dict[str, list[str]]] = {}
    for tab in ElementTree.parse(layout).iter("Tab"):
        for split in tab.iter("DockSplitter"):
            assert (
                int(split.get("count", "0")) == len(split) == len(split.get("sizes", "").split(";"))
            )
        found[tab.get("tab_name", "")] = {
            area.get("name", ""): [curve.get("name", "") for curve in area.iter("curve")]
            for area in tab.iter("DockArea")
        }
    return found


def leaves(layout: Any) -> list[str]:
    """Return the panels of a layout of Foxglove."""
    if isinstance(layout, str):
        return [layout]
    return leaves(layout["first"]) + leaves(layout["second"])


def test_plotjuggler_finds_every_joint_by_name(model: Path, tmp_path: Path) -> None:
    file = tmp_path / "torque.xml"
    outcome = lagrangian_ff("layout", model, "--plotjuggler", file)
    assert outcome.code == 0, outcome
    torque, residual = plots(file).values()
    assert tuple(torque) == tuple(residual) == JOINTS
    for number, joint in enumerate(JOINTS):
        assert torque[joint] == [
            f"/joint_states/{joint}/effort",
            f"/monitor/predicted/{joint}/effort",
            f"/feedforward/feedforward/{joint}/effort",
            f"/feedforward/commands/data[{number}]",
        ]
        assert residual[joint] == [f"/monitor/residual/{joint}/effort"]


def test_foxglove_shows_what_has_the_order_of_the_model(model: Path, tmp_path: Path) -> None:
    file = tmp_path / "torque.json"
    outcome = lagrangian_ff(
        "layout", model, "--foxglove", file, "--namespace", "/left/", "--json", "-"
    )
    assert outcome.code == 0, outcome
    layout = json.loads(file.read_text())
    panels = layout["configById"]
    assert sorted(leaves(layout["layout"])) == sorted(panels)
    assert len(panels) == 2 * len(JOINTS)
    shown = [path["value"] for panel in panels.values() for path in panel["paths"]]
    assert len(set(shown)) == len(shown)
    for number in range(len(JOINTS)):
        for topic in ("monitor/predicted", "monitor/residual", "feedforward/feedforward"):
            assert f"/left/{topic}.effort[{number}]" in shown
        assert f"/left/feedforward/commands.data[{number}]" in shown
    assert not any("joint_states" in value for value in shown)


def test_mistakes_are_said(model: Path, tmp_path: Path) -> None:
    assert_refused(lagrangian_ff("layout", model), "--plotjuggler FILE.xml")
    wrong = lagrangian_ff("layout", model, "--foxglove", tmp_path / "torque.xml")
    assert_refused(wrong, "ends in .json")
