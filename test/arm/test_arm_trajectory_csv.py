"""Trajectories in CSV files."""

import os
from pathlib import Path

import numpy as np
import pytest

from lagrangian_ff.arm import Trajectory, exciting_trajectory, read_trajectory, write_trajectory
from lagrangian_ff.errors import ArmError


@pytest.fixture(scope="module")
def trajectory() -> Trajectory:
    return exciting_trajectory(4, duration=5.0)


def test_what_is_written_is_read_to_the_last_bit(tmp_path: Path, trajectory: Trajectory) -> None:
    path = tmp_path / "motion.csv"
    effort = np.random.default_rng(0).normal(size=trajectory.q.shape)
    carrier = Trajectory(
        trajectory.time, trajectory.q, trajectory.qd, trajectory.qdd, effort=effort
    )
    for original in (trajectory, carrier):
        write_trajectory(path, original)
        again = read_trajectory(path)
        for name in ("time", "q", "qd", "qdd", "effort"):
            np.testing.assert_array_equal(getattr(again, name), getattr(original, name))
        assert again.joints == trajectory.joints
        assert again.notes == ()


def test_missing_derivatives_are_filled_in_and_said(tmp_path: Path, trajectory: Trajectory) -> None:
    path = tmp_path / "positions.csv"
    header = "time," + ",".join(f"position/{joint}" for joint in trajectory.joints)
    table = np.column_stack([trajectory.time, trajectory.q])[::10]
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.17g")
    again = read_trajectory(path)
    np.testing.assert_allclose(again.qd, trajectory.qd[::10], atol=0.02)
    np.testing.assert_allclose(again.qdd, trajectory.qdd[::10], atol=0.4)
    assert "velocity and acceleration filled in" in again.notes[0]


def test_other_joints_in_other_columns_are_read(tmp_path: Path) -> None:
    path = tmp_path / "two.csv"
    path.write_text(
        "velocity/elbow,position/elbow,time,position/hip,velocity/hip,comment\n"
        "0.5,1,0,2,0.25,7\n0.5,1.5,1,2.25,0.25,8\n"
    )
    again = read_trajectory(path)
    assert again.joints == ("elbow", "hip")
    np.testing.assert_array_equal(again.q, [[1, 2], [1.5, 2.25]])
    np.testing.assert_array_equal(again.qd, [[0.5, 0.25], [0.5, 0.25]])
    assert "acceleration filled in" in again.notes[0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "a header and at least one point"),
        ("time,position/a\n", "a header and at least one point"),
        ("t,position/a\n0,1\n", "no column 'time'"),
        ("time,a\n0,1\n", "no column 'position/<joint>'"),
        ("time,position/a\n0,1\n1,x\n", "line 3: column position/a holds 'x'"),
        ("time,position/a\n0,1\n1,nan\n", "line 3: position/a is nan"),
        ("time,position/a\n0,1\n1\n", "line 3: 1 cells, the header has 2"),
        ("time,position/a\n0,1\n1,2\n1,3\n", "line 4: time does not increase"),
        ("time,position/a,position/b,velocity/a\n0,1,1,1\n", "not velocity/b"),
    ],
)
def test_bad_files_are_named_with_line_and_column(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(ArmError, match=words) as caught:
        read_trajectory(path)
    assert "bad.csv" in str(caught.value)


def test_files_that_cannot_be_opened_are_named(tmp_path: Path, trajectory: Trajectory) -> None:
    with pytest.raises(ArmError, match=r"nowhere\.csv: no such file"):
        read_trajectory(tmp_path / "nowhere.csv")
    with pytest.raises(ArmError, match="cannot be written"):
        write_trajectory(tmp_path / "no" / "folder.csv", trajectory)
    (tmp_path / "bytes.csv").write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(ArmError, match="not a CSV text file"):
        read_trajectory(tmp_path / "bytes.csv")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time,position/a\n0,1\n1e-300,2\n1,3\n2,1\n3,0\n4,1\n", "no spline goes through"),
        ("time,position/a\n0,1\n1,1e308\n", r"line 3: position/a is 1e\+308"),
        ("time,position/a,position/a\n0,1,1\n", "line 1: a column is given twice"),
        ("time,position/a\n0," + "1" * 200_000, "line 2: 200002 characters"),
        ('time,position/a\n0,"1\n' + "1,1\n" * 50_000, "larger than field limit"),
        (",".join(f"position/{n}" for n in range(40_000)), "line 1: .* in 40000 columns"),
    ],
)
def test_what_would_overflow_or_exhaust_is_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(ArmError, match=message) as refused:
        read_trajectory(path)
    assert str(path) in str(refused.value)


def test_a_trajectory_is_no_pipe(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.csv")
    with pytest.raises(ArmError, match="is a pipe, expected a file"):
        read_trajectory(tmp_path / "pipe.csv")
