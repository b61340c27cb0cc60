"""Bad input, each kind: a clear error or a stated repair, never a traceback or a lost file."""

import sqlite3
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cli_examples import JOINTS, QUICK, Outcome, arm, assert_refused, csv, lagrangian_ff

from lagrangian_ff.identification import Model
from lagrangian_ff.recording import Recording, write_bag, write_npz


def identify(source: Path, *arguments: str) -> Outcome:
    """Identify by friction alone, which is quick; the model goes beside the source."""
    return lagrangian_ff(
        "identify", source, *QUICK, "--model", "none+fri",
        "--output", source.parent / "model.npz", *arguments,
    )  # fmt: skip


def assert_learned(outcome: Outcome, source: Path, *words: str) -> None:
    """A model was written, and these were said."""
    assert outcome.code == 0, outcome
    assert Model.load(source.parent / "model.npz").joints == JOINTS
    missing = [word for word in words if word not in outcome.text]
    assert not missing, f"{missing} not in: {outcome.text}"


def test_no_such_file(tmp_path: Path) -> None:
    assert_refused(identify(tmp_path / "arm_bag"), "arm_bag", "no such file")
    assert list(tmp_path.iterdir()) == []


def test_not_a_recording(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("hello")
    (tmp_path / "empty").mkdir()
    (tmp_path / "bag.db3").write_text("hello")
    (tmp_path / "bag.mcap").write_text("hello")
    (tmp_path / "arrays.npz").write_text("hello")
    (tmp_path / "table.csv").write_text("hello")
    for name in ("notes.txt", "empty", "bag.db3", "bag.mcap", "arrays.npz", "table.csv"):
        assert_refused(identify(tmp_path / name), name)
    assert not (tmp_path / "model.npz").exists()


def test_a_bag_of_other_topics(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", arm(4.0), topic="/left/joint_states")
    assert_refused(identify(bag, "--topic", "/right"), "bag", "/right", "/left/joint_states")


def test_the_topic_of_a_bag_that_holds_several(tmp_path: Path) -> None:
    write_bag(tmp_path / "bag", arm())
    assert_learned(identify(tmp_path / "bag", "--topic", "joint_states"), tmp_path / "bag")


def test_a_truncated_bag_is_used_as_far_as_it_goes(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", arm())
    (file,) = bag.glob("*.mcap")
    data = file.read_bytes()
    file.write_bytes(data[: int(0.7 * len(data))])
    outcome = identify(bag)
    assert_learned(outcome, bag, "note: ", "cut off or damaged")
    assert outcome.text.count("cut off or damaged") == 1


def test_a_truncated_sqlite_bag(tmp_path: Path) -> None:
    path = tmp_path / "bag.db3"
    with sqlite3.connect(path) as database:
        database.execute("create table other (x)")
    path.write_bytes(path.read_bytes()[:600])
    assert_refused(identify(path), "bag.db3")


def test_a_missing_joint(tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm(4.0))
    assert_refused(identify(source, "--joints", "shoulder,wrist"), "arm.csv", "wrist", "elbow")


@pytest.mark.parametrize("kind", ["csv", "npz", "bag"])
def test_no_effort(kind: str, tmp_path: Path) -> None:
    recording = arm(4.0)
    recording = replace(recording, effort=np.full_like(recording.effort, np.nan))
    source = _written(kind, tmp_path, recording)
    assert_refused(identify(source), source.name, "effort", "0.000 s")


def test_no_effort_on_one_joint(tmp_path: Path) -> None:
    recording = arm(4.0)
    recording.effort[:, 1] = np.nan
    source = csv(tmp_path / "arm.csv", recording)
    assert_refused(identify(source), "arm.csv", "elbow", "effort")


def test_all_zero_effort(tmp_path: Path) -> None:
    recording = arm(4.0)
    recording.effort[:] = 0.0
    source = write_bag(tmp_path / "bag", recording)
    assert_refused(identify(source), "/joint_states", "effort", "0 in all")


def test_nan_in_between_is_bridged_and_said(tmp_path: Path) -> None:
    recording = arm()
    recording.effort[500:503, 1] = np.nan
    source = csv(tmp_path / "arm.csv", recording)
    assert_learned(identify(source), source, "elbow", "no effort in 3 of 2400", "5.000 s")


def test_stamps_out_of_order_and_repeated_are_repaired_and_said(tmp_path: Path) -> None:
    recording = arm()
    order = np.arange(len(recording))
    order[[100, 101]] = order[[101, 100]]
    order[200] = order[199]
    mixed = Recording(
        JOINTS, recording.time[order], recording.position[order], recording.velocity[order],
        recording.effort[order],
    )  # fmt: skip
    source = csv(tmp_path / "arm.csv", mixed)
    assert_learned(
        identify(source), source, "1 sample arrived out of order", "stamps repeated by 1 sample"
    )


def test_fewer_samples_than_one_block(tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm(2.0))
    assert_refused(identify(source, "--block", "3"), "arm.csv", "block", "3 s", "--train")


def test_a_single_block_cannot_be_validated(tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm(5.0))
    assert_refused(identify(source, "--train", "0.3"), "blocks", "record longer")


def test_recordings_of_other_joints(tmp_path: Path) -> None:
    one = csv(tmp_path / "one.csv", arm(4.0, joints=("a", "b")))
    two = csv(tmp_path / "two.csv", arm(4.0, joints=("a", "c")))
    arguments = ("identify", one, two, "--output", tmp_path / "model.npz")
    assert_refused(lagrangian_ff(*arguments), "one.csv", "two.csv", "--joints a")


def test_a_cell_that_is_no_number(tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm(4.0))
    lines = source.read_text().splitlines()
    lines[7] = lines[7].replace(",", ",x", 1)
    source.write_text("\n".join(lines))
    assert_refused(identify(source), "arm.csv", "line 8", "position/shoulder")


def test_an_arm_that_stands_still(tmp_path: Path) -> None:
    recording = arm(4.0)
    recording.position[:] = 0.5
    source = write_npz(tmp_path / "arm.npz", recording)
    assert_refused(identify(source), "arm.npz", "no joint moves")


def test_a_joint_that_stands_still_is_named(tmp_path: Path) -> None:
    recording = arm()
    recording.position[:, 1] = 0.5
    recording.velocity[:, 1] = 0.0
    source = csv(tmp_path / "arm.csv", recording)
    assert_learned(identify(source), source, "elbow did not move")


def _written(kind: str, folder: Path, recording: Recording) -> Path:
    if kind == "csv":
        return csv(folder / "arm.csv", recording)
    if kind == "npz":
        return write_npz(folder / "arm.npz", recording)
    return write_bag(folder / "bag", recording)
