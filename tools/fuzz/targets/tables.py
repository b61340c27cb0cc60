"""Recordings in CSV and npz, and trajectories in CSV."""

from pathlib import Path
from typing import Any

import numpy as np

from fuzz.target import Target, swinging
from fuzz.targets.bags import read
from lagrangian_ff import recording
from lagrangian_ff.arm import Trajectory, read_trajectory, write_trajectory

CSV_TOKENS = (
    b"time",
    b"position/",
    b"velocity/",
    b"effort/",
    b"temperature/",
    b"time,time",
    b"a/b",
)
NPZ_TOKENS = (
    b"PK\x03\x04",
    b"PK\x01\x02",
    b"PK\x05\x06",
    b"\x93NUMPY\x01\x00",
    b"'descr': '|O'",
    b"<f8",
    b"|S0",
    b"'shape': (1000000000000,)",
    b"'shape': (-1, -300)",
    b"fortran_order': True",
    b"<c16",
    b"<U9",
)


def _csv(folder: Path) -> None:
    one = swinging()
    recording.write_csv(folder / "plain.csv", one)
    velocity = one.velocity.copy()
    velocity[::7] = np.nan
    holes = recording.Recording(one.joints, one.time + 1.7e9, one.position, velocity, one.effort)
    recording.write_csv(folder / "holes.csv", holes)


def _npz(folder: Path) -> None:
    one = swinging()
    recording.write_npz(folder / "plain.npz", one)
    arrays: dict[str, Any] = {"times": one.time, "positions": one.position, "torques": one.effort}
    np.savez_compressed(folder / "theirs.npz", **arrays)


def _trajectory(folder: Path) -> None:
    one = swinging(60, 6)
    whole = Trajectory(one.time, one.position, one.velocity, -one.position, effort=one.effort)
    write_trajectory(folder / "whole.csv", whole)
    header, *rows = (folder / "whole.csv").read_text().splitlines()
    kept = [",".join(row.split(",")[:7]) for row in (header, *rows)]
    (folder / "positions.csv").write_text("\n".join(kept))


def _read_trajectory(path: Path) -> None:
    found = read_trajectory(path)
    found.sample(np.linspace(found.time[0], found.time[-1], 50))


CSV = Target("csv", _csv, read, CSV_TOKENS)
NPZ = Target("npz", _npz, read, NPZ_TOKENS, archive=True)
TRAJECTORY = Target("trajectory", _trajectory, _read_trajectory, CSV_TOKENS)
