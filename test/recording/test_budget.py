"""Files made to exhaust whoever reads them are refused: soon, in little memory, by their name."""

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import hostile_files
import numpy as np
import pytest
from recording_examples import swinging

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording import condition, inspect, load

SAID = {
    "overflow_in_a_circle": "no joint states",
    "file_of_zeros": "unpacks to more than 3",
    "chunk_of_zeros": "the chunk at byte 8 claims to hold 300 MiB",
    "many_chunks": "chunks unpack to more than",
    "packed_twice": "chunks unpack to more than 32",
    "messages_of_zeros": "messages hold more than",
    "archive_of_zeros": "claims to unpack to 256 MiB",
    "archive_that_claims": "claims the shape (1000000000000,)",
    "empty_texts": "claims the shape (1000000000000,)",
    "pickled": "is a pickle, which is never read since that can execute code",
    "many_columns": "line 1: 540037 characters in 40003 columns",
    "long_cell": "line 2: 200003 characters, expected at most 10000",
    "quote": "not a CSV text file: field larger than field limit",
    "pipe": "is a pipe, expected a file",
    "device": "is a device, expected a file",
    "plug": "is a socket, expected a file",
    "device_in_a_bag": "metadata.yaml: is a device",
    "names_of_their_own": "2998 joints, expected at most 1000",
}


def memory(field: str) -> int:
    """Return bytes of this process: VmRSS, or VmHWM, the most since it was set back."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) << 10 for line in lines if line.startswith(field))


@pytest.fixture(autouse=True)
def _little_memory() -> Iterator[None]:
    before = memory("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")
    yield
    assert memory("VmHWM") - before < 500 << 20


@pytest.mark.parametrize("made", hostile_files.REFUSED, ids=lambda made: made.__name__)
def test_what_would_exhaust_its_reader_is_refused(
    made: Callable[[Path], Path], tmp_path: Path
) -> None:
    path = made(tmp_path)
    begin = time.process_time()
    with pytest.raises(RecordingError) as refused:
        load(path)
    assert SAID[made.__name__] in str(refused.value)
    assert str(path) in str(refused.value)
    assert time.process_time() - begin < 5.0
    assert "allow_pickle" not in str(refused.value)


@pytest.mark.parametrize("made", hostile_files.READ, ids=lambda made: made.__name__)
def test_what_is_sound_beside_it_is_read(made: Callable[[Path], Path], tmp_path: Path) -> None:
    begin = time.process_time()
    assert len(load(made(tmp_path))) == 300
    assert time.process_time() - begin < 5.0


@pytest.mark.parametrize("quantity", ["position", "effort"])
@pytest.mark.parametrize("value", [1e308, -1e200, 1e13])
def test_values_that_no_joint_has_are_named(quantity: str, value: float) -> None:
    recording = swinging(600)
    table = getattr(recording, quantity).copy()
    table[300:340, 1] = value
    odd = replace(recording, **{quantity: table})
    inspect(odd)
    with pytest.raises(RecordingError, match=f"{quantity} .*elbow .*in sample 301 at 0.600 s"):
        condition(odd)


def test_a_stamp_beyond_all_clocks_is_named() -> None:
    recording = swinging(600)
    time = recording.time.copy()
    time[300] = -1e308
    with pytest.raises(RecordingError, match=r"time is beyond 1e\+20 s .* sample 301"):
        condition(replace(recording, time=time))


def test_joints_of_several_publishers_share_a_table_however_many(tmp_path: Path) -> None:
    path = hostile_files.names_of_their_own(tmp_path, 200)
    assert len(load(path).joints) == 398
    assert np.isfinite(load(path).position).sum() == 398


def test_a_single_stamp_far_ahead_of_its_sample_is_borne() -> None:
    recording = swinging(300, 200.0)
    time = recording.time.copy()
    time[57] += 0.716
    assert len(condition(replace(recording, time=time))) > 200
