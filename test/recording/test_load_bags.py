"""Bags that are whole: storages, compressions, topics, joint orders, stamps."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recording_examples import STORE, TYPE, assert_same, foreign_bag, message, messages_of, swinging
from rosbags.rosbag2 import StoragePlugin, Writer

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording import load

KINDS = [
    ("mcap", "none"),
    ("mcap", "storage"),
    ("mcap", "message"),
    ("mcap", "file"),
    ("sqlite3", "none"),
    ("sqlite3", "message"),
    ("sqlite3", "file"),
]


@pytest.mark.parametrize(("storage", "compression"), KINDS)
def test_every_storage_and_compression_reads_the_same(
    tmp_path: Path, storage: str, compression: str
) -> None:
    expected = swinging(3000)
    bag = foreign_bag(tmp_path / "bag", messages_of(expected), storage, compression)
    found = load(bag)
    assert_same(found, expected)
    assert found.notes == ()
    assert found.start == expected.start
    (file,) = (file for file in bag.iterdir() if file.name != "metadata.yaml")
    assert_same(load(file), expected)


def test_a_directory_without_metadata_is_read_and_says_so(tmp_path: Path) -> None:
    bag = foreign_bag(tmp_path / "bag", messages_of(swinging(50)))
    (bag / "metadata.yaml").unlink()
    found = load(bag)
    assert_same(found, swinging(50))
    assert "metadata.yaml is missing" in found.notes[0]


def test_a_split_bag_is_read_in_the_order_of_its_numbers(tmp_path: Path) -> None:
    expected = swinging(120)
    parts = np.array_split(np.arange(120), 12)
    bag = tmp_path / "bag"
    bag.mkdir()
    messages = messages_of(expected)
    for number, part in enumerate(parts):
        piece = foreign_bag(tmp_path / f"piece_{number}", [messages[k] for k in part])
        shutil.move(piece / f"piece_{number}.mcap", bag / f"bag_{number}.mcap")
    assert_same(load(bag), expected)


def test_files_that_metadata_promises_and_that_are_gone_are_named(tmp_path: Path) -> None:
    bag = foreign_bag(tmp_path / "bag", messages_of(swinging(50)))
    text = (bag / "metadata.yaml").read_text()
    (bag / "metadata.yaml").write_text(text.replace("- bag.mcap", "- bag.mcap\n  - bag_1.mcap", 1))
    assert any("bag_1.mcap, which is not there" in note for note in load(bag).notes)


def test_several_topics_need_a_choice(tmp_path: Path) -> None:
    bag = foreign_bag(
        tmp_path / "bag", messages_of(swinging(20)), topic="/left/state", others=["/right/state"]
    )
    with pytest.raises(RecordingError, match="/left/state, /right/state"):
        load(bag)
    assert_same(load(bag, topic="left/state"), swinging(20))
    with pytest.raises(RecordingError, match="no topic /middle; joint states are on /left/state"):
        load(bag, topic="/middle")


def test_the_usual_topic_is_preferred_with_a_note(tmp_path: Path) -> None:
    bag = foreign_bag(
        tmp_path / "bag", messages_of(swinging(20)), topic="/arm/joint_states", others=["/other"]
    )
    found = load(bag)
    assert_same(found, swinging(20))
    assert "/other" in found.notes[0]
    assert found.source.endswith("(/arm/joint_states)")


def test_a_bag_without_joint_states_says_what_it_holds(tmp_path: Path) -> None:
    text = STORE.types["std_msgs/msg/String"](data="hello")
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/chat", "std_msgs/msg/String", typestore=STORE)
        writer.write(connection, 1, STORE.serialize_cdr(text, "std_msgs/msg/String"))
    with pytest.raises(RecordingError, match=r"no joint states.*/chat \[std_msgs/msg/String\]"):
        load(tmp_path / "bag")
    with pytest.raises(RecordingError, match=f"/chat is not of type {TYPE}"):
        load(tmp_path / "bag", topic="/chat")


def test_missing_velocity_and_effort_are_nan(tmp_path: Path) -> None:
    bag = foreign_bag(tmp_path / "bag", [(k, message(k, ["a"], [0.1 * k])) for k in range(1, 9)])
    found = load(bag)
    assert np.isnan(found.velocity).all()
    assert np.isnan(found.effort).all()
    assert not np.isnan(found.position).any()


def test_publishers_that_take_turns_share_one_table(tmp_path: Path) -> None:
    messages = []
    for k in range(1, 6):
        messages.append((2 * k, message(2 * k, ["a", "b"], [k, -k], effort=[1, 2])))
        messages.append((2 * k + 1, message(2 * k + 1, ["c"], [10 * k])))
    found = load(foreign_bag(tmp_path / "bag", messages))
    assert found.joints == ("a", "b", "c")
    assert np.array_equal(found.position[::2, :2], [[k, -k] for k in range(1, 6)])
    assert np.array_equal(found.position[1::2, 2], [10 * k for k in range(1, 6)])
    assert np.isnan(found.position[::2, 2]).all()
    assert np.isnan(found.position[1::2, :2]).all()


@settings(max_examples=15, deadline=None)
@given(st.lists(st.permutations(["shoulder", "elbow", "wrist", "gripper"]), min_size=3, max_size=9))
def test_the_order_of_joints_in_a_message_does_not_matter(orders: list[list[str]]) -> None:
    value = {"shoulder": 1.0, "elbow": 2.0, "wrist": 3.0, "gripper": 4.0}
    messages = [
        (
            k + 1,
            message(k + 1, names, [value[n] + k for n in names], effort=[value[n] for n in names]),
        )
        for k, names in enumerate(orders)
    ]
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        bag = foreign_bag(Path(folder) / "bag", messages)
        found = load(bag, joints=["wrist", "shoulder"])
    assert found.joints == ("wrist", "shoulder")
    assert np.array_equal(found.position, [[3.0 + k, 1.0 + k] for k in range(len(orders))])
    assert np.array_equal(found.effort, np.tile([3.0, 1.0], (len(orders), 1)))


def test_a_joint_that_is_not_there_is_named_with_those_that_are(tmp_path: Path) -> None:
    bag = foreign_bag(tmp_path / "bag", messages_of(swinging(20)))
    with pytest.raises(RecordingError, match="no joint tool; it holds shoulder, elbow, wrist"):
        load(bag, joints=["tool"])


def test_unset_header_stamps_fall_back_to_the_time_of_reception(tmp_path: Path) -> None:
    messages = [(10**18 + 2_000_000 * k, message(0, ["a"], [k])) for k in range(5)]
    found = load(foreign_bag(tmp_path / "bag", messages))
    assert np.allclose(found.time, 0.002 * np.arange(5), atol=1e-9)
    assert "5 of 5 messages have no header stamp" in found.notes[0]


def test_simulated_time_that_starts_at_zero_is_kept(tmp_path: Path) -> None:
    messages = [(10**18 + k, message(2_000_000 * k, ["a"], [k])) for k in range(5)]
    found = load(foreign_bag(tmp_path / "bag", messages))
    assert np.allclose(found.time, 0.002 * np.arange(5), atol=1e-9)
    assert found.notes == ()


def test_malformed_messages_are_left_out_and_counted(tmp_path: Path) -> None:
    messages = messages_of(swinging(20))
    messages[7] = (messages[7][0], messages[7][1][:60])
    found = load(foreign_bag(tmp_path / "bag", messages))
    assert len(found) == 19
    assert any("left out 1 message " in note for note in found.notes)


def test_what_is_no_recording_is_refused_with_the_reason(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="no such file"):
        load(tmp_path / "absent.mcap")
    (tmp_path / "text.pdf").write_text("hello")
    with pytest.raises(RecordingError, match="not a recording; expected one of"):
        load(tmp_path / "text.pdf")
    (tmp_path / "empty").mkdir()
    with pytest.raises(RecordingError, match="not a bag"):
        load(tmp_path / "empty")
    for suffix in (".mcap", ".db3", ".mcap.zstd", ".db3.zstd"):
        for content in (b"", b"this is not a bag at all" * 100):
            fake = tmp_path / f"fake{suffix}"
            fake.write_bytes(content)
            with pytest.raises(RecordingError, match="fake"):
                load(fake)
