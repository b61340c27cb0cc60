"""The counts of judgements, their table and their figure."""

import json
from typing import Any

import numpy as np
import pytest
from matplotlib.patches import Rectangle

from lagrangian_ff.studies.hidden.plants import Built, Plant
from lagrangian_ff.studies.hidden.results import HiddenResults


def line(
    group: str, size: float = 0.1, outcome: str = "right", *, effect: str = "ripple",
    ratio: float | None = 1.0, absorbed: bool = False, count: int = 1,
) -> list[dict[str, Any]]:  # fmt: skip
    hidden = Built(
        effect=effect,
        joint="joint_2",
        size=size,
        catalogue=[effect],
        joints=["joint_2"],
        absorbed=absorbed,
        physics="",
        strength=1.0,
        facts={},
        reached=[size] * 2,
        visible=[0.6 * size] * 2,
    )
    plant = Plant("", [] if group == "clean" else [hidden], 0, 0, group, [], [], [])
    cannot = {"effect": "stribeck", "joint": "joint_2"}
    false = ["stribeck on joint_1"] if outcome == "wrong" else []
    return [
        {
            "case": f"{group}-{effect}-{size}-{outcome}-{k}",
            "group": group,
            "plant": plant.record(),
            "judgement": {"outcome": outcome, "false": false, "suggested": []},
            "record": {"not_observable": [cannot]},
            "ratio": ratio,
        }
        for k in range(count)
    ]


LINES = [
    *line("alone", count=6),
    *line("alone", outcome="class", count=2),
    *line("alone", outcome="wrong", ratio=3.0),
    *line("alone", outcome="nothing", ratio=2.0, effect="stribeck"),
    *line("alone", size=0.02, outcome="nothing", ratio=1.3),
    *line("alone", outcome="nothing", effect="spring", absorbed=True),
    *line("pair", outcome="part"),
    *line("clean", outcome="nothing", count=19),
    *line("clean", outcome="wrong"),
    *line("outside", outcome="nothing", effect="pitting", ratio=None),
]


def test_the_summary_counts_what_was_judged() -> None:
    found = HiddenResults.of(LINES)
    numbers = found.record()
    row = numbers["sizes"]["0.1"]
    assert (row["cases"], row["right"], row["class"], row["wrong"], row["nothing"]) == (
        10, 6, 2, 1, 1,
    )  # fmt: skip
    assert numbers["visible"]["0.05-0.1"] == row
    # Stribeck friction was missed and said not to be observable, the ripple of 2 % only missed.
    assert (row["told"], numbers["sizes"]["0.02"]["told"]) == (1, 0)
    assert numbers["absorbed"]["0.1"]["nothing"] == 1
    assert numbers["pairs"]["0.1"]["part"] == 1
    assert (numbers["clean"]["cases"], numbers["clean"]["wrong"]) == (20, 1)
    assert 0.05 < numbers["clean"]["high"] < 0.3
    assert numbers["outside"]["wrong"] == 0
    assert numbers["ratio"]["0.1"]["median"] == 1.0
    assert numbers["ratio"]["0.1"]["within_1.1"] == pytest.approx(0.8)
    assert numbers["effects"]["stribeck"]["0.1"]["nothing"] == 1
    json.dumps(numbers)
    text = "\n".join(found.table())
    assert "0.60" in text
    assert "nothing hidden: 1 of 20" in text
    assert "one that some models hold already, so that nothing is right too, by size:" in text


def test_what_no_strength_makes_large_counts_under_what_it_reached() -> None:
    weak = line("alone", size=0.1, outcome="nothing")
    weak[0]["plant"]["hidden"][0]["reached"] = [0.048, 0.06]
    numbers = HiddenResults.of([*line("alone", size=0.1), *weak]).record()
    assert numbers["sizes"]["0.1"]["nothing"] == 0
    assert numbers["sizes"]["0.05"]["nothing"] == 1


def test_the_figure_holds_what_the_summary_says() -> None:
    drawn = HiddenResults.of(LINES).figure()
    bars, ratios, effects = drawn.axes
    assert [t.get_text() for t in bars.get_xticklabels()][:2] == ["2 %", "10 %"]
    boxes = [patch for patch in bars.patches if isinstance(patch, Rectangle)]
    tall = [box.get_height() for box in boxes if box.get_x() + 0.5 * box.get_width() == 1.0]
    assert tall[0] == pytest.approx(0.6)
    assert sum(tall) == pytest.approx(1.0)
    shown = [len(np.asarray(points.get_xdata())) for points in ratios.lines]
    assert [count for count in shown if count != 2] == [1, 10]
    assert [t.get_text() for t in effects.get_yticklabels()] == ["stribeck", "ripple", "spring"]


def test_a_study_without_results_draws_and_prints() -> None:
    found = HiddenResults.of([])
    assert found.table() == ["0 cases"]
    found.figure()
