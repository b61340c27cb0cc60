"""The writer of bags: what others read, what a kill leaves, what is refused."""

import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from recording_examples import STORE, TYPE, assert_same, decoded, message, messages_of, swinging
from rosbags.rosbag2 import Reader

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording import BagWriter, load, write_bag


def test_the_library_reads_directory_and_metadata(tmp_path: Path) -> None:
    recording = swinging(100)
    path = write_bag(tmp_path / "bag", recording, topic="arm/joint_states")
    with Reader(path) as reader:
        (connection,) = reader.connections
        assert (connection.topic, connection.msgtype) == ("/arm/joint_states", TYPE)
        assert connection.digest == STORE.hash_rihs01(TYPE)
        assert connection.msgdef.data == STORE.generate_msgdef(TYPE, ros_version=2)[0]
        assert connection.msgcount == reader.message_count == 100
        assert reader.start_time == 1_700_000_000 * 10**9
        assert reader.duration == 99 * 2_000_000 + 1
        states = [decoded(data) for _, _, data in reader.messages()]
    assert np.array_equal([state.position for state in states], recording.position)
    assert states[3].name == list(recording.joints)


def test_velocity_and_effort_that_nobody_measured_stay_empty(tmp_path: Path) -> None:
    recording = swinging(10)
    recording.velocity[:] = recording.effort[:] = np.nan
    with Reader(write_bag(tmp_path / "bag", recording)) as reader:
        data = next(data for _, _, data in reader.messages())
    state = decoded(data)
    assert len(state.velocity) == len(state.effort) == 0


def test_infinite_values_are_values(tmp_path: Path) -> None:
    recording = swinging(10)
    recording.effort[:] = np.inf
    assert_same(load(write_bag(tmp_path / "bag", recording)), recording)


def test_messages_in_any_order_keep_the_order_of_arrival(tmp_path: Path) -> None:
    expected = swinging(20)
    rows = np.random.default_rng(5).permutation(20)
    messages = messages_of(expected)
    with BagWriter(tmp_path / "bag") as bag:
        for row in rows:
            bag.append(messages[row][1], messages[row][0])
    found = load(tmp_path / "bag")
    assert np.array_equal(found.position, expected.position[rows])
    assert found.notes == ()


CHILD = """
import sys, time
import numpy as np
from lagrangian_ff.recording import BagWriter
from lagrangian_ff.recording.joint_state import JointStateEncoder
bag = BagWriter(sys.argv[1])
encoder = JointStateEncoder(("a", "b"), velocity=False)
number = 0
begin = time.monotonic()
while True:
    stamp, row = 1000 * 10**9 + number * 10**6, np.array([[number, -number]])
    bag.append(encoder.encode(np.array([stamp]), row, row, row)[0], stamp)
    number += 1
    if number % 100 == 0:
        print(number, flush=True)
    time.sleep(max(0.0, begin + number / 1000 - time.monotonic()))
"""


def test_nothing_appended_is_lost_when_the_process_is_killed(tmp_path: Path) -> None:
    path = tmp_path / "bag"
    with subprocess.Popen(
        [sys.executable, "-c", CHILD, str(path)], stdout=subprocess.PIPE, text=True
    ) as child:
        assert child.stdout is not None
        told = [int(child.stdout.readline()) for _ in range(8)]
        child.send_signal(signal.SIGKILL)
        told += [int(line) for line in child.stdout]
    assert child.returncode == -signal.SIGKILL
    found = load(path)
    assert len(found) >= told[-1] >= 800
    number = np.arange(len(found))
    assert np.array_equal(found.position, np.column_stack([number, -number]))
    assert np.allclose(found.time, number / 1000, atol=1e-6)
    notes = " ".join(found.notes)
    assert "metadata.yaml is missing" in notes
    assert "ends without its closing record" in notes or "ends inside the record" in notes


def test_closing_twice_is_harmless_and_appending_afterwards_is_told(tmp_path: Path) -> None:
    bag = BagWriter(tmp_path / "bag")
    bag.append(message(10**9, ["a"], [0.5]), 10**9)
    assert bag.count == 1
    bag.close()
    bag.close()
    with pytest.raises(RecordingError, match="closed"):
        bag.append(message(2 * 10**9, ["a"], [0.5]), 2 * 10**9)
    assert len(load(tmp_path / "bag")) == 1


def test_an_empty_bag_is_closed_cleanly_and_refused_on_load(tmp_path: Path) -> None:
    BagWriter(tmp_path / "bag").close()
    with pytest.raises(RecordingError, match="no joint state can be read"):
        load(tmp_path / "bag")


def test_a_place_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match="cannot be written"):
        BagWriter(tmp_path / "file" / "bag")


def test_stamps_that_do_not_fit_a_message_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="do not fit a ROS 2 message"):
        write_bag(tmp_path / "bag", swinging(10, start=-5.0))
    assert not (tmp_path / "bag").exists()
