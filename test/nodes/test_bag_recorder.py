"""Joint states reach the disk as they came, whatever comes between them."""

import resource
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.nodes.recorder.bag_recorder import BagRecorder, lasting
from lagrangian_ff.recording import load
from lagrangian_ff.recording.joint_state import JointStateEncoder

START = 1_700_000_000_000_000_000


class Source:
    """Stands for a subscription."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._waiting: list[tuple[bytes, int]] = []
        self.warnings: list[str] = []

    def send(self, *messages: bytes) -> None:
        with self._lock:
            self._waiting += [(message, START + i) for i, message in enumerate(messages)]

    def take(self) -> Iterator[tuple[bytes, int]]:
        with self._lock:
            waiting, self._waiting = self._waiting, []
        yield from waiting

    def warn(self, kind: str, text: str) -> None:
        self.warnings.append(kind)


@pytest.fixture
def source() -> Source:
    return Source()


@pytest.fixture
def recorder(source: Source) -> Iterator[BagRecorder]:
    recorder = BagRecorder(source.take, source.warn)
    yield recorder
    recorder.stop()


def states(count: int, effort: bool = True, position: float = 0.5) -> list[bytes]:
    stamps = START + 2_000_000 * np.arange(count, dtype=np.int64)
    table = np.full((count, 2), position)
    return JointStateEncoder(("a", "b"), effort=effort).encode(stamps, table, table, table)


def test_what_comes_between_open_and_close_is_in_the_bag(
    source: Source, recorder: BagRecorder, tmp_path: Path
) -> None:
    source.send(*states(5))
    recorder.open(tmp_path / "bag", "joint_states")
    source.send(*states(100))
    recorder.close_bag()
    source.send(*states(7))
    tally = recorder.tally
    assert str(tally) == "100 samples, 0.20 s, 500.0 Hz"
    assert tally.joints == ("a", "b")
    recording = load(tmp_path / "bag")
    assert len(recording) == 100
    np.testing.assert_allclose(np.diff(recording.time), 0.002, atol=1e-9)


def test_bad_messages_are_told_apart(source: Source, recorder: BagRecorder, tmp_path: Path) -> None:
    recorder.open(tmp_path / "bag", "joint_states")
    source.send(b"", b"junk", *states(3), *states(1, position=np.nan), *states(2, effort=False))
    recorder.close_bag()
    assert source.warnings == [
        "not a joint state", "not a joint state", "unusable joint state", "no effort",
    ]  # fmt: skip
    assert recorder.tally.samples == 6
    assert recorder.received == 6


def test_an_existing_bag_is_not_overwritten(
    source: Source, recorder: BagRecorder, tmp_path: Path
) -> None:
    (tmp_path / "bag").mkdir()
    with pytest.raises(RecordingError, match="exists already"):
        recorder.open(tmp_path / "bag", "joint_states")


def test_a_full_disk_ends_the_recording_and_is_reported(
    source: Source, recorder: BagRecorder, tmp_path: Path
) -> None:
    recorder.open(tmp_path / "bag", "joint_states")
    (bag,) = (tmp_path / "bag").glob("*.*")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (bag.stat().st_size, before[1]))
    try:
        source.send(*states(3000))
        recorder.close_bag()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert "cannot be written" in recorder.failure
    assert source.warnings == ["recording ended"]
    assert recorder.tally.samples == 0


def test_a_recording_ends_whole_before_the_disk_is_full(
    source: Source, recorder: BagRecorder, tmp_path: Path
) -> None:
    recorder.open(tmp_path / "bag", "joint_states", reserve=10**18)
    source.send(*states(3))
    deadline = time.monotonic() + 10.0
    while not recorder.failure and time.monotonic() < deadline:
        time.sleep(0.01)
    assert "are free beside" in recorder.failure
    assert source.warnings == ["recording ended"]
    assert (tmp_path / "bag" / "metadata.yaml").is_file()
    assert len(load(tmp_path / "bag")) == 3


@pytest.mark.parametrize(
    ("free", "rate", "expected"),
    [
        (10_500_000_000, 0.0, "the disk has 10.0 GB for recordings (0.5 GB stay free)"),
        (10_500_000_000, 1e6, "stay free): 3 h at 1 MB/s"),
        (100_500_000_000, 2e5, "stay free): 139 h at 0.2 MB/s"),
        (100, 1e6, "0.0 GB for recordings (0.5 GB stay free): 0 min"),
    ],
)
def test_it_is_said_how_long_the_disk_lasts(free: int, rate: float, expected: str) -> None:
    assert expected in lasting(free, 500_000_000, rate)


def test_it_writes_without_being_asked(
    source: Source, recorder: BagRecorder, tmp_path: Path
) -> None:
    recorder.open(tmp_path / "bag", "joint_states")
    source.send(*states(3))
    deadline = time.monotonic() + 10.0
    while recorder.tally.samples < 3 and time.monotonic() < deadline:
        time.sleep(0.01)
    assert len(load(tmp_path / "bag")) == 3, "on disk before the bag is closed"


def test_a_recording_has_its_own_joints_and_times_also_without_stamps(
    source: Source, recorder: BagRecorder, tmp_path: Path
) -> None:
    source.send(*states(3))
    recorder.open(tmp_path / "bag", "joint_states")
    still = np.zeros((11, 1))
    other = JointStateEncoder(("c",), effort=True).encode(
        np.zeros(11, dtype=np.int64), still, still, still
    )
    source.send(*other)
    recorder.close_bag()
    assert recorder.joints == ("a", "b", "c")
    assert recorder.tally.joints == ("c",)
    assert recorder.tally.seconds > 0.0
