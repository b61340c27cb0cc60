"""Recordings of any layout are read as the file of what is known says."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from measured_examples import states, torques, write, write_known

from lagrangian_ff.errors import UserError
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.studies.measured.known import Part, known_arms
from lagrangian_ff.studies.measured.reading import contacts, motions, read

TIME, Q, QD, QDD = states(12.0)
TAU = torques(Q, QD, QDD)


def first(folder: Path, **changes: Any) -> Recording:
    write_known(folder, **changes)
    (arm,) = known_arms(folder)
    return read(arm, arm.sources["one"])


def same(found: Recording, tau: np.ndarray = TAU) -> None:
    for name, expected in (("time", TIME), ("position", Q), ("velocity", QD), ("effort", tau)):
        np.testing.assert_allclose(getattr(found, name), expected, atol=1e-12)


def test_columns_by_name_and_by_number(tmp_path: Path) -> None:
    write(tmp_path / "one.csv")
    same(first(tmp_path))
    numbers = {"time": 0, "position": [1, 2], "velocity": [3, 4], "effort": [5, 6]}
    same(first(tmp_path, read=numbers))


def test_files_side_by_side_with_a_number_a_line(tmp_path: Path) -> None:
    files = {"time": TIME, "position": Q, "velocity": QD, "effort": TAU}
    for name, values in files.items():
        np.savetxt(tmp_path / f"{name}.txt", values.ravel(), fmt="%.17g")
    recordings = {"one": {"file": {name: f"{name}.txt" for name in files}}, "two": "two.csv"}
    same(first(tmp_path, read=None, recordings=recordings))


def test_a_matlab_struct_in_degrees_with_gears(tmp_path: Path) -> None:
    gears = np.array([100.0, 50.0])
    struct = {"t": TIME, "q": np.degrees(Q).T, "v": np.degrees(QD).T, "motor": (TAU / gears).T}
    scipy.io.savemat(tmp_path / "one.mat", {"rec": struct})
    layout = {
        "variable": "rec",
        "time": "t",
        "position": "q",
        "velocity": "v",
        "effort": "motor",
        "degrees": True,
        "effort_scale": gears.tolist(),
    }
    same(first(tmp_path, read=layout, recordings={"one": "one.mat", "two": "two.csv"}))


def test_torque_that_was_injected_is_taken_off_and_found_again(tmp_path: Path) -> None:
    write(tmp_path / "one.csv", pulse=True)
    read_ = {"effort_minus": ["p1", "p2"]}
    recordings = {"one": {"file": "one.csv", "read": read_}, "two": "one.csv"}
    contact = {"columns": ["p1", "p2"], "above": 0.1}
    same(first(tmp_path, recordings=recordings, contact=contact))
    (arm,) = known_arms(tmp_path)
    assert np.ptp(read(arm, arm.sources["two"]).effort - TAU) == pytest.approx(0.5)
    np.testing.assert_allclose(contacts(arm, arm.sources["one"]), [(2.0, 3.0)], atol=0.011)


def test_parts_are_cut_by_time_before_anything_is_filtered(tmp_path: Path) -> None:
    write(tmp_path / "one.csv")
    write_known(tmp_path, recordings={"one": "one.csv", "two": "one.csv"})
    (arm,) = known_arms(tmp_path)
    begin, end = motions(arm, [Part("one", (0.0, 0.5)), Part("one", (0.5, 1.0))])
    assert begin.time[-1] < 6.0 < end.time[0]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({}, r"one\.csv: no such file, which .* names as one"),
        ({"read": {"time": "t"}, "made": True}, "no column t; it holds"),
        ({"read": {"time": 0, "position": [1, 2]}, "made": True}, "where the effort of one stands"),
    ],
)
def test_what_is_missing_is_named(tmp_path: Path, changes: dict[str, Any], says: str) -> None:
    if changes.pop("made", False):
        write(tmp_path / "one.csv")
    with pytest.raises(UserError, match=says):
        first(tmp_path, **changes)
