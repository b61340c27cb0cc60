"""A planar arm of two joints, its recordings as files, and what is known of it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio

from lagrangian_ff.arrays import Floats
from lagrangian_ff.studies.measured.kinematics import STANDARD, Kinematics, Row

JOINTS = ("shoulder", "elbow")
ROWS = (Row(0.3, 0.0, 0.0, 0.0, 0.6, (-0.1, 0.0, 0.0)), Row(0.2, 0.0, 0.0, 0.0, 0.5))
PENDULUM = Kinematics("made up", None, STANDARD, ROWS, (9.81, 0.0, 0.0))
FRICTION = np.array([[0.05, 0.2, 0.01], [0.03, 0.1, -0.02]])
"""Viscous, Coulomb and constant torque by joint."""


def states(seconds: float, rate: float = 100.0, seed: int = 0) -> tuple[Floats, ...]:
    """Return time, position, velocity and acceleration of a motion that repeats nothing."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, seconds, 1.0 / rate)
    frequency = random.uniform(0.5, 4.0, (4, 2))
    phase, size = random.uniform(0.0, 6.0, (4, 2)), random.uniform(0.2, 0.5, (4, 2))
    angle = time[:, None, None] * frequency + phase
    q, qd, qdd = (
        np.sum(size * frequency**k * np.sin(angle + k * np.pi / 2), axis=1) for k in range(3)
    )
    return time, q, qd, qdd


def torques(q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """Return the torque of the rigid bodies and of friction, by Pinocchio's Newton and Euler."""
    body = pinocchio.buildModelFromXML(PENDULUM.text(JOINTS))
    body.gravity.linear = np.array(PENDULUM.gravity)
    data = body.createData()
    rigid = [pinocchio.rnea(body, data, *row) for row in zip(q, qd, qdd, strict=True)]
    viscous, coulomb, constant = FRICTION.T
    return np.asarray(np.array(rigid) + viscous * qd + coulomb * np.tanh(qd / 0.02) + constant)


def write(path: Path, seconds: float = 12.0, seed: int = 0, pulse: bool = False) -> None:
    """Write a recording as text with a header; with `pulse`, torque that was injected for 1 s."""
    time, *motion = states(seconds, seed=seed)
    tau = torques(*motion)
    injected = np.zeros_like(tau)
    if pulse:
        injected[(time >= 2.0) & (time <= 3.0), 0] = 0.5
    values = np.column_stack([time, motion[0], motion[1], tau + injected, injected])
    names = "time, q1, q2, v1, v2, t1, t2, p1, p2"
    np.savetxt(path, values, delimiter=",", header=names, comments="")


def known(**changes: Any) -> dict[str, Any]:
    """Return what a file says of the pendulum; a field that is changed to None is left out."""
    fields = {
        "joints": list(JOINTS),
        "read": {
            "time": "time",
            "position": ["q1", "q2"],
            "velocity": ["v1", "v2"],
            "effort": ["t1", "t2"],
        },
        "recordings": {"one": "one.csv", "two": "two.csv"},
        "splits": {"1-2": {"train": ["one"], "test": ["two"]}},
        "kinematics": {
            "convention": "standard",
            "gravity": [9.81, 0.0, 0.0],
            "rows": [{"a": 0.3, "mass": 0.6, "centre": [-0.1, 0.0, 0.0]}, {"a": 0.2, "mass": 0.5}],
        },
        **changes,
    }
    return {name: value for name, value in fields.items() if value is not None}


def write_known(folder: Path, **changes: Any) -> Path:
    """Write known.json of the pendulum into a folder, which is made."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "known.json"
    path.write_text(json.dumps(known(**changes)))
    return path
