"""Bags where libraries are missing: by rosbag2_py where ROS is installed, else what to install."""

import importlib
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from recording_examples import assert_same, foreign_bag, messages_of, swinging

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording import BagWriter, load, write_bag

STAND_IN = Path(__file__).parent / "ros_stand_in"
COMPRESSED = [("mcap", "storage"), ("mcap", "message"), ("sqlite3", "file"), ("sqlite3", "message")]

Without = Callable[..., None]


@pytest.fixture
def without(monkeypatch: pytest.MonkeyPatch) -> Without:
    """Return what hides libraries, with ROS' bags beside them or not."""

    def hide(*names: str, ros: bool = False) -> None:
        monkeypatch.delitem(sys.modules, "rosbag2_py", raising=False)
        if ros:
            monkeypatch.syspath_prepend(STAND_IN)
            # The stand-in itself unpacks with the libraries that are hidden from the package.
            importlib.import_module("rosbag2_py")
        else:
            monkeypatch.setitem(sys.modules, "rosbag2_py", None)
        for name in names:
            monkeypatch.setitem(sys.modules, name, None)

    return hide


@pytest.mark.parametrize(("storage", "compression"), COMPRESSED)
def test_ros_reads_what_is_compressed(
    storage: str, compression: str, tmp_path: Path, without: Without
) -> None:
    expected = swinging(50)
    bag = foreign_bag(tmp_path / "bag", messages_of(expected), storage, compression)
    without("zstandard", "lz4", ros=True)
    assert_same(load(bag), expected, 1e-9)


@pytest.mark.parametrize(("storage", "compression"), COMPRESSED)
def test_without_ros_it_is_said_what_to_install(
    storage: str, compression: str, tmp_path: Path, without: Without
) -> None:
    bag = foreign_bag(tmp_path / "bag", messages_of(swinging(50)), storage, compression)
    without("zstandard", "lz4")
    with pytest.raises(RecordingError) as caught:
        load(bag)
    for part in (str(bag), "python3-zstandard", "pip install zstandard", "ros-jazzy-rosbag2-py"):
        assert part in str(caught.value)


def test_what_ros_cannot_read_says_why(tmp_path: Path, without: Without) -> None:
    bag = foreign_bag(tmp_path / "bag", messages_of(swinging(50)), "sqlite3", "file")
    (bag / "metadata.yaml").unlink()
    without("zstandard", "lz4", ros=True)
    with pytest.raises(RecordingError, match=r"rosbag2 cannot read it .*python3-zstandard"):
        load(bag)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_bag_that_is_not_compressed_needs_no_library(
    storage: str, tmp_path: Path, without: Without
) -> None:
    expected = swinging(50)
    bag = foreign_bag(tmp_path / "bag", messages_of(expected), storage)
    without("zstandard", "lz4", "mcap")
    assert_same(load(bag), expected, 1e-9)


def test_ros_writes_the_same_bag(tmp_path: Path, without: Without) -> None:
    recording = swinging(50)
    ours = write_bag(tmp_path / "ours", recording, topic="arm/joint_states")
    without("mcap", ros=True)
    theirs = write_bag(tmp_path / "theirs", recording, topic="arm/joint_states")
    assert_same(load(theirs), load(ours))
    assert (theirs / "metadata.yaml").exists()


def test_what_ros_cannot_write_is_an_error_with_the_place(tmp_path: Path, without: Without) -> None:
    without("mcap", ros=True)
    (tmp_path / "bag").mkdir()
    with pytest.raises(RecordingError, match=r"bag: exists already"):
        BagWriter(tmp_path / "bag")
    with BagWriter(tmp_path / "other") as bag:
        bag.append(messages_of(swinging(1))[0][1], 5)
    with pytest.raises(RecordingError, match="closed"):
        bag.append(b"", 6)


def test_nothing_that_writes_bags_is_said(tmp_path: Path, without: Without) -> None:
    without("mcap")
    with pytest.raises(RecordingError, match=r"ros-jazzy-rosbag2-py.*pip install mcap"):
        write_bag(tmp_path / "bag", swinging(5))
    assert not (tmp_path / "bag").exists()
