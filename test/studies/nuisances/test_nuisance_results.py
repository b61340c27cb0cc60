"""The counts of judgements, the targets, the table and the figure."""

import json
from typing import Any

import pytest

from lagrangian_ff.studies.hidden.plants import Built
from lagrangian_ff.studies.nuisances.drawn import Nuisances
from lagrangian_ff.studies.nuisances.plants import NuisancePlant
from lagrangian_ff.studies.nuisances.results import NuisanceResults

DELAYED = next(seed for seed in range(50) if Nuisances.draw(seed).delay)
PROMPT = next(seed for seed in range(50) if not Nuisances.draw(seed).delay)


def lines(
    group: str, outcome: str, *false: str, size: float = 0.1, count: int = 1, moving: float = 40.0,
    seed: int = DELAYED, refused: str | None = None, after: float = 0.9,
) -> list[dict[str, Any]]:  # fmt: skip
    hidden = Built(
        effect="ripple",
        joint="joint_2",
        size=size,
        catalogue=["ripple"],
        joints=["joint_2"],
        absorbed=False,
        physics="",
        strength=1.0,
        facts={},
        reached=[size] * 2,
        visible=[size] * 2,
    )
    plant = NuisancePlant(
        "", group, 0, [] if group == "clean" else [hidden], Nuisances.draw(seed),
        [50.0] * 2, [moving] * 2, [0.0] * 2, [],
    )  # fmt: skip
    return [
        {
            "case": f"{group}-{outcome}-{size}-{len(false)}-{moving}-{seed}-{k}",
            "group": group,
            "plant": plant.record(),
            "judgement": {"outcome": outcome, "false": list(false), "suggested": []},
            "record": {},
            "added": [{"effect": "ripple", "joint": "joint_2", "before": 1.0, "after": after}],
            "refused": refused,
        }
        for k in range(count)
    ]


LINES = [
    *lines("alone", "right", count=8),
    *lines("alone", "class"),
    *lines("alone", "nothing", moving=12.0, refused="too short"),
    *lines("alone", "right", "delay on joint_1", size=0.05, seed=PROMPT),
    *lines("clean", "nothing", count=40),
    *lines("clean", "wrong", "stribeck on joint_1", "delay on joint_3", seed=PROMPT),
    *lines("outside", "nothing", count=5, after=1.2),
]


def test_the_summary_counts_what_was_judged() -> None:
    found = NuisanceResults.of(LINES)
    numbers = found.record()
    assert numbers["sizes"]["0.1"] == {
        "cases": 10, "able": 10, "named": 8, "as_class": 1, "wrong": 0, "refused": 1,
    }  # fmt: skip
    assert numbers["long"]["0.1"]["cases"] == 9
    # An effect is named although something wrong is, too.
    assert (numbers["sizes"]["0.05"]["named"], numbers["sizes"]["0.05"]["wrong"]) == (1, 1)
    delay = numbers["nuisances"]["delay"]
    assert (delay["with"]["wrong"], delay["without"]["wrong"]) == (0, 2)
    assert numbers["names"] == {"delay": 2, "stribeck": 1}
    assert len(numbers["raised"]) == 5
    json.dumps(numbers)
    text = "\n".join(found.table())
    assert "wrong names: delay (2), stribeck (1)" in text
    assert "ripple on joint_2: 1 to 1.2 N·m" in text


@pytest.mark.parametrize(
    ("target", "holds"),
    [
        ("wrong", False), ("named_10", True), ("named_5", True), ("clean", True),
        ("outside", True), ("raised", False),
    ],
)  # fmt: skip
def test_each_target_is_held_against_its_figure(target: str, holds: bool) -> None:
    findings = NuisanceResults.of(LINES).findings
    assert findings is not None
    assert findings[target].holds is holds


def test_the_figure_and_an_empty_study_are_drawn() -> None:
    sizes, moving, nuisances = NuisanceResults.of(LINES).figure().axes
    assert [label.get_text() for label in sizes.get_xticklabels()] == ["5 %", "10 %"]
    assert len(nuisances.get_yticklabels()) == 11
    assert moving.lines
    empty = NuisanceResults.of([])
    assert empty.table()[0] == "0 arms"
    empty.figure()
