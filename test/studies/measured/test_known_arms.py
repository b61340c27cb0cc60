"""What is known of an arm is read as it is written, or refused with file, field and reason."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from measured_examples import JOINTS, write_known

from lagrangian_ff.errors import UserError
from lagrangian_ff.studies.measured.known import Expected, Part, known_arms

ROOT = Path(__file__).resolve().parents[3]


def test_a_file_is_read(tmp_path: Path) -> None:
    part = {"recording": "one", "share": [0.5, 1.0]}
    split = {"train": ["one"], "test": [part], "confirm": ["two"]}
    may = [{"effects": ["stribeck"], "joints": ["elbow"], "source": "seen"}]
    write_known(tmp_path / "arm", splits={"half": split}, may=may)
    (arm,) = known_arms(tmp_path)
    assert (arm.name, arm.joints) == ("arm", JOINTS)
    assert arm.sources["one"].files[""] == tmp_path / "arm" / "one.csv"
    assert arm.splits[0].test == (Part("one", (0.5, 1.0)),)
    assert arm.splits[0].search == arm.splits[0].train
    assert arm.may == (Expected(("stribeck",), ("elbow",)),)
    assert arm.kinematics is not None
    assert arm.kinematics.rows[0].mass == 0.6


def test_files_may_lie_apart_from_the_recordings(tmp_path: Path) -> None:
    write_known(tmp_path / "known").rename(tmp_path / "known" / "lab.json")
    (tmp_path / "data").mkdir()
    (arm,) = known_arms(tmp_path / "data", tmp_path / "known")
    assert arm.name == "lab"
    assert arm.sources["two"].files[""] == tmp_path / "data" / "two.csv"


def test_a_layout_of_one_recording_changes_that_of_all(tmp_path: Path) -> None:
    apart = {"file": "one.csv", "read": {"degrees": True, "effort_scale": [2.0, 3.0]}}
    write_known(tmp_path, recordings={"one": apart, "two": "two.csv"})
    (arm,) = known_arms(tmp_path)
    one, two = arm.sources["one"].layout, arm.sources["two"].layout
    assert one.degrees
    assert one.effort_scale == (2.0, 3.0)
    assert one.columns == two.columns
    assert not two.degrees


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"joints": None}, "joints is None, expected a list of names"),
        ({"robot": "x"}, "the file has robot; it may have name, about"),
        ({"recordings": {}}, "recordings is {}, expected names with values"),
        ({"splits": {"s": {"train": ["three"], "test": ["one"]}}}, "is 'three', expected one of"),
        ({"splits": {"s": {"train": ["one"]}}}, "split s test is None, expected recordings"),
        ({"kinematics": {"convention": "dh"}}, "convention is 'dh', expected standard or modified"),
        (
            {"kinematics": {"convention": "standard", "rows": [{"a": 1.0}]}},
            "one for each of the 2 joints",
        ),
        ({"may": [{"effects": ["rust"]}]}, r"may effects is \['rust'\], expected some of"),
        ({"must": [{"effects": ["contact"], "joints": ["hip"]}]}, "expected some of shoulder"),
        ({"read": {"effort_scale": [1.0]}}, "read effort_scale is .* expected 2 numbers"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, changes: dict[str, Any], says: str) -> None:
    path = write_known(tmp_path, **changes)
    with pytest.raises(UserError, match=says) as raised:
        known_arms(tmp_path)
    assert str(path) in str(raised.value)


def test_folders_that_do_not_serve(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="no such folder"):
        known_arms(tmp_path / "nowhere")
    with pytest.raises(UserError, match=r"holds no known\.json"):
        known_arms(tmp_path)
    write_known(tmp_path / "a", name="same")
    write_known(tmp_path / "b", name="same")
    with pytest.raises(UserError, match="same is described twice"):
        known_arms(tmp_path)
    (tmp_path / "a" / "known.json").write_text("{")
    with pytest.raises(UserError, match="cannot be read"):
        known_arms(tmp_path / "a")


def test_the_arms_of_the_project_are_known(tmp_path: Path) -> None:
    """Their recordings need not be there."""
    arms = known_arms(tmp_path, ROOT / "config" / "measured")
    assert len(arms) >= 8
    for arm in arms:
        assert arm.kinematics is not None
        assert len(arm.kinematics.robot(arm.joints).movable) == len(arm.joints)
        assert np.linalg.norm(arm.kinematics.gravity) == pytest.approx(9.81)
