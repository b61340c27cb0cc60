"""Which recordings and which model a task is given, and what it is refused for."""

from pathlib import Path
from typing import Any

import pytest

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.recorder.order import Order, Task
from lagrangian_ff.nodes.recorder.ordering import make_order, summary
from lagrangian_ff.nodes.recorder.session import Result, Session

FINDING = {
    "effect": "stribeck", "joints": ["b"], "verdict": "confirmed", "shape": {}, "why": "it is",
    "evidence_gain": 1.0, "p_value": 0.1,
}  # fmt: skip


@pytest.fixture
def values(tmp_path: Path) -> dict[str, Any]:
    return {
        "output_directory": str(tmp_path), "effects_file": "", "model_file": "", "joints": [""],
        "model": "motor+fri", "prismatic": [""], "urdf": "", "use_robot_description": False,
        "landmarks": -1, "positive": True,
        "train": 0.5, "samples": 50, "loss": "huber", "bandwidth": 20.0,
        "effort_scale.a": 2.0, "effort_offset.a": 0.1, "add.effect": "", "add.joint": "",
    }  # fmt: skip


def recorded(tmp_path: Path, count: int) -> Session:
    return Session(
        bags=[tmp_path / f"bag_{number}" for number in range(1, count + 1)],
        result=Result(tmp_path / "old.npz", {}),
    )


def order(task: Task, session: Session, values: dict[str, Any]) -> Order:
    return make_order(task, session, values.__getitem__, "/joint_states", ["a"])


def names(bags: tuple[str, ...]) -> list[str]:
    return [Path(bag).name for bag in bags]


@pytest.mark.parametrize(
    ("task", "count", "used", "confirm"),
    [
        (Task.IDENTIFY, 2, ["bag_1", "bag_2"], []),
        (Task.COMPARE, 3, ["bag_3"], []),
        (Task.DIAGNOSE, 1, ["bag_1"], []),
        (Task.DIAGNOSE, 3, ["bag_1", "bag_2"], ["bag_3"]),
    ],
)
def test_each_task_gets_its_recordings(
    tmp_path: Path, values: dict[str, Any], task: Task, count: int, used: list[str],
    confirm: list[str],
) -> None:  # fmt: skip
    made = order(task, recorded(tmp_path, count), values)
    assert (names(made.bags), names(made.confirm)) == (used, confirm)
    assert made.effort_scale == {"a": 2.0}
    told = summary(made)
    assert all(name in told for name in [*used, *confirm])
    if task is Task.DIAGNOSE:
        assert ("held back" in told) == (count == 1)


def test_settings_of_the_identification_are_those_of_the_command_line(
    tmp_path: Path, values: dict[str, Any]
) -> None:
    made = order(Task.IDENTIFY, recorded(tmp_path, 1), values)
    assert (made.prismatic, made.landmarks, made.positive) == ((), None, True)
    values.update(prismatic=["rail", "lift"], landmarks=0, positive=False)
    made = order(Task.IDENTIFY, recorded(tmp_path, 1), values)
    assert (made.prismatic, made.landmarks, made.positive) == (("rail", "lift"), 0, False)


def test_the_description_is_a_file_or_what_came_on_the_topic(
    tmp_path: Path, values: dict[str, Any]
) -> None:
    session = recorded(tmp_path, 1)
    args = Task.IDENTIFY, session, values.__getitem__, "/joint_states", ["a"]
    assert make_order(*args, "<robot/>").urdf == ""
    values["use_robot_description"] = True
    with pytest.raises(UserError, match="nothing came on the topic robot_description"):
        make_order(*args)
    written = Path(make_order(*args, "<robot name='ü'/>").urdf)
    assert written.read_text(encoding="utf-8") == "<robot name='ü'/>"
    assert written.parent == tmp_path
    values["urdf"] = str(tmp_path / "arm.urdf")
    with pytest.raises(UserError, match="set one of the two"):
        make_order(*args, "<robot/>")
    values["use_robot_description"] = False
    made = make_order(*args, "<robot/>")
    assert Order.from_json(made.to_json()).urdf == str(tmp_path / "arm.urdf")


def test_nothing_that_is_there_is_overwritten(tmp_path: Path, values: dict[str, Any]) -> None:
    (tmp_path / "bag_1_compare.json").touch()
    made = order(Task.COMPARE, recorded(tmp_path, 1), values)
    assert Path(made.output).name == "bag_1_compare_2.json"


def test_the_model_is_the_last_one_or_the_one_that_is_named(
    tmp_path: Path, values: dict[str, Any]
) -> None:
    session = recorded(tmp_path, 1)
    named = tmp_path / "named.npz"
    values["model_file"] = str(named)
    assert order(Task.COMPARE, session, values).model_file == str(tmp_path / "old.npz")
    session.result = None
    with pytest.raises(UserError, match="which does not exist"):
        order(Task.COMPARE, session, values)
    named.touch()
    assert order(Task.COMPARE, session, values).model_file == str(named)
    values["model_file"] = ""
    with pytest.raises(UserError, match="call ~/identify first"):
        order(Task.COMPARE, session, values)


def test_what_is_added_was_asked_for_or_confirmed(tmp_path: Path, values: dict[str, Any]) -> None:
    session = recorded(tmp_path, 1)
    with pytest.raises(UserError, match="call ~/diagnose first"):
        order(Task.ADD, session, values)
    session.found[Task.DIAGNOSE] = {"findings": [{**FINDING, "verdict": "suggested"}]}
    with pytest.raises(UserError, match="confirmed no effect"):
        order(Task.ADD, session, values)
    session.found[Task.DIAGNOSE] = {"findings": [FINDING]}
    made = order(Task.ADD, session, values)
    assert [str(each) for each in made.additions] == ["stribeck on b"]
    assert Path(made.output) == tmp_path / "old_stribeck_b.npz"
    values["add.effect"] = "drift"
    with pytest.raises(UserError, match=r"set the parameter add\.joint, too"):
        order(Task.ADD, session, values)
    values["add.joint"] = "a"
    assert [str(each) for each in order(Task.ADD, session, values).additions] == ["drift on a"]
