"""CSV and npz: round trips, and what is wrong in a file told by line and column."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from recording_examples import assert_same, equal, swinging

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording import Recording, load, write_bag, write_csv, write_npz

HEADER = "time,position/a,velocity/a,effort/a\n"


@st.composite
def recordings(draw: st.DrawFn) -> Recording:
    samples = draw(st.integers(1, 30))
    joints = draw(
        st.lists(st.text("abcxyz/ 12", min_size=1, max_size=6), min_size=1, max_size=4, unique=True)
    )
    joints = [joint.strip() or "joint" for joint in joints]
    joints = list(dict.fromkeys(joints))
    shape = (samples, len(joints))
    # Position is there: a message whose joints tell nothing at all has no sample in a table.
    position = draw(arrays(np.float64, shape, elements=st.floats(-1e3, 1e3)))
    velocity, effort = (draw(arrays(np.float64, shape, elements=st.floats())) for _ in range(2))
    steps = draw(st.lists(st.integers(-50, 1000), min_size=samples, max_size=samples))
    stamps = np.cumsum(steps) * 1_000_000
    return Recording(
        joints=tuple(joints),
        time=(stamps - stamps[0]) / 1e9,
        position=position,
        velocity=velocity,
        effort=effort,
        start=draw(st.sampled_from([100.0, 1_700_000_000.5])),
    )


@settings(max_examples=30, deadline=None)
@given(recordings())
def test_round_trips_keep_every_number(recording: Recording) -> None:
    with TemporaryDirectory() as folder:
        written = (
            write_csv(Path(folder) / "table.csv", recording),
            write_npz(Path(folder) / "table.npz", recording),
            write_bag(Path(folder) / "bag", recording),
        )
        for path in written:
            found = load(path)
            assert_same(found, recording, tolerance=1e-12)
            if path.suffix != ".csv":
                assert found.start == recording.start
            assert found.notes == ()


@pytest.mark.parametrize(
    ("write", "name"), [(write_csv, "a.csv"), (write_npz, "a.npz"), (write_bag, "a")]
)
def test_nothing_is_overwritten_unless_told(tmp_path: Path, write: object, name: str) -> None:
    assert callable(write)
    path = tmp_path / name
    write(path, swinging(20))
    with pytest.raises(RecordingError, match="exists already; not overwritten"):
        write(path, swinging(30))
    assert len(load(path)) == 20
    if write is not write_bag:  # a bag is never replaced
        write(path, swinging(30), overwrite=True)
        assert len(load(path)) == 30


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1: no column `time`"),
        ("stamp,position/a\n0,1\n", "line 1: no column `time`"),
        ("time,effort/a\n0,1\n", "line 1: no column position/a"),
        ("time,time,position/a\n0,0,1\n", "line 1: column given twice: time"),
        (HEADER + "0,1,2,3\n1,1,two,3\n", "line 3: column velocity/a holds 'two'"),
        (HEADER + "0,1,2,3\n\n1,1,2\n", "line 4: 3 cells, the header has 4"),
        (HEADER + "0,1,2,3\n,1,2,3\n", "time is not a number in 1 samples, first in sample 2"),
        (HEADER, "holds no samples"),
    ],
)
def test_a_bad_table_is_told_by_line_and_column(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(RecordingError) as caught:
        load(path)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)


def test_columns_may_lack_come_in_any_order_or_mean_something_else(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    path.write_text("effort/b,time,position/b,comment,position/a\n5,0.5,1,7,2\n,1.5,,7,3\n")
    found = load(path)
    assert found.joints == ("b", "a")
    assert equal(found.time, np.array([0.5, 1.5]))
    assert equal(found.position, np.array([[1.0, 2.0], [np.nan, 3.0]]))
    assert equal(found.effort, np.array([[5.0, np.nan], [np.nan, np.nan]]))
    assert np.isnan(found.velocity).all()


def test_a_spreadsheet_table_with_windows_line_ends_is_read(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    path.write_bytes(
        b"\xef\xbb\xbf" + HEADER.replace("\n", "\r\n").encode() + b"0,1,2,3\r\n1,1,2,3\r\n"
    )
    assert len(load(path)) == 2


def test_dates_become_seconds_since_the_start(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    path.write_text("time,position/a\n1700000000.25,0\n1700000000.75,1\n")
    found = load(path)
    assert found.start == 1700000000.25
    assert equal(found.time, np.array([0.0, 0.5]))


def test_archives_under_other_names_and_without_joints(tmp_path: Path) -> None:
    one = swinging(5)
    path = tmp_path / "theirs.npz"
    np.savez(path, times=one.time, positions=one.position, torques=one.effort)
    found = load(path)
    assert found.joints == ("joint_1", "joint_2", "joint_3")
    assert equal(found.effort, one.effort)
    assert np.isnan(found.velocity).all()


def test_bad_archives_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "bad.npz"
    np.savez(path, time=np.arange(3.0))
    with pytest.raises(RecordingError, match="no array `position`"):
        load(path)
    np.savez(path, time=np.arange(3.0), position=np.zeros(3))
    with pytest.raises(RecordingError, match=r"position \(3,\)"):
        load(path)
    np.savez(path, time=np.arange(3.0), position=np.zeros((3, 2)), effort=np.zeros((2, 2)))
    with pytest.raises(RecordingError, match=r"effort has shape \(2, 2\)"):
        load(path)
    np.savez(path, time=np.arange(3.0), position=np.array([[print]] * 3))
    with pytest.raises(RecordingError, match="position holds Python objects"):
        load(path)
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(RecordingError, match="damaged, or no"):
        load(path)


@pytest.mark.parametrize("byte", [0, 1, *b"'(9"])
def test_a_damaged_archive_is_never_a_crash(tmp_path: Path, byte: int) -> None:
    path = tmp_path / "arm.npz"
    # Long enough that the header is read before the archive's checksum can tell.
    t = np.arange(0.0, 20.0, 0.01)
    arm = {"position": np.sin(t)[:, None], "velocity": np.cos(t)[:, None], "effort": t[:, None]}
    np.savez(path, time=t, **arm)
    whole = path.read_bytes()
    first = whole.index(b"\x93NUMPY")
    refused = 0
    for place in range(first, first + 128):
        path.write_bytes(whole[:place] + bytes([byte]) + whole[place + 1 :])
        try:
            load(path)
        except RecordingError as error:
            refused += 1
            assert str(path) in str(error)  # noqa: PT017
    assert refused > 50


@pytest.mark.parametrize("point", [0x110000, 0xFF000000, 0xD800])
def test_a_name_that_is_no_text_is_refused(tmp_path: Path, point: int) -> None:
    names = np.array([ord("a"), point, ord("b"), 0], dtype=np.uint32).view("U2")
    path = tmp_path / "named.npz"
    np.savez(path, time=np.arange(3.0), position=np.zeros((3, 2)), joints=names)
    with pytest.raises(RecordingError, match=r"named\.npz: array joints holds what is no text"):
        load(path)
