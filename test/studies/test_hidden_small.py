"""A small version of the study, with the diagnosis itself: one hidden effect, and none."""

from pathlib import Path

import pytest

from lagrangian_ff.diagnosis.ground import tuning
from lagrangian_ff.diagnosis.search import confirm
from lagrangian_ff.studies.common.run import run
from lagrangian_ff.studies.common.study import Request
from lagrangian_ff.studies.hidden.examiner import Diagnosis
from lagrangian_ff.studies.hidden.plants import Stretches
from lagrangian_ff.studies.hidden.study import HiddenStudy

SHORT = Stretches(((2, 6.0), (6, 12.0)))


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tuning, "ROWS", 2100)
    monkeypatch.setattr(confirm, "ROWS", 2100)


def test_a_ripple_is_named_and_a_clean_arm_is_left_alone(tmp_path: Path) -> None:
    clean, ripple = (
        run(
            HiddenStudy(
                Request(quick=True, only=name),
                tmp_path,
                examined=Diagnosis("chain+fri", steps=1),
                stretches=SHORT,
            ),
            tmp_path,
        )[0]
        for name in ("clean-00", "ripple-joint_2-20")
    )
    assert clean["judgement"] == {"outcome": "nothing", "false": [], "suggested": []}
    assert ripple["judgement"]["outcome"] == "right"
    (found,) = ripple["record"]["findings"]
    order = ripple["plant"]["hidden"][0]["facts"]["times a turn"]
    assert found["shape"]["order"] == order
    assert ripple["ratio"] < 1.1
    assert ripple["errors"]["found"]["joint_2"] < ripple["errors"]["base"]["joint_2"]
