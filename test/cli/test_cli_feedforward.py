"""`feedforward`: the torque of a trajectory, its parts, and where the model guesses."""

import json
from pathlib import Path

import numpy as np
import pytest
from cli_examples import JOINTS, assert_refused, lagrangian_ff, motion, process, small_model, torque

from lagrangian_ff.arm import Trajectory, read_trajectory, write_trajectory
from lagrangian_ff.identification import Model


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of a model of the small arm."""
    return small_model(tmp_path_factory.mktemp("feedforward") / "model.npz")


def trajectory(path: Path, joints: tuple[str, ...] = JOINTS, reach: float = 0.8) -> Path:
    """Write a trajectory of 5 s."""
    write_trajectory(path, Trajectory(*motion(5.0, 100.0, reach), joints=joints))
    return path


def test_the_torque_is_that_of_the_arm(model: Path, tmp_path: Path) -> None:
    out = tmp_path / "torque.csv"
    outcome = process("feedforward", model, trajectory(tmp_path / "t.csv"), "--output", out)
    assert outcome.code == 0, outcome
    done = read_trajectory(out)
    assert done.joints == JOINTS
    assert done.effort is not None
    error = done.effort - torque(done.q, done.qd, done.qdd)
    assert np.sqrt(np.mean(error**2)) < 0.4
    assert "lies outside" not in outcome.text


@pytest.mark.parametrize(
    ("without", "kept"),
    [
        (("gravity",), {"inertia", "coriolis", "viscous", "coulomb"}),
        (("friction",), {"gravity", "inertia", "coriolis", "offset"}),
        (("friction,gravity",), {"inertia", "coriolis"}),
        (("coulomb", "inertia"), {"gravity", "coriolis", "viscous", "offset"}),
    ],
)
def test_parts_are_left_out(
    without: tuple[str, ...], kept: set[str], model: Path, tmp_path: Path
) -> None:
    out = tmp_path / "torque.csv"
    source = trajectory(tmp_path / "t.csv")
    outcome = lagrangian_ff(
        "feedforward", model, source, "--output", out, "--without", *without
    )  # fmt: skip
    assert outcome.code == 0, outcome
    done = read_trajectory(out)
    terms = Model.load(model).terms(done.q, done.qd, done.qdd)
    parts = {"gravity": terms.gravity, "inertia": terms.inertia, "coriolis": terms.coriolis}
    parts |= terms.effects
    assert done.effort is not None
    assert np.allclose(done.effort, sum(parts[name] for name in kept), atol=1e-9)


def test_an_unknown_part(model: Path, tmp_path: Path) -> None:
    out = tmp_path / "torque.csv"
    outcome = lagrangian_ff(
        "feedforward", model, trajectory(tmp_path / "t.csv"), "--output", out,
        "--without", "stiction",
    )  # fmt: skip
    assert_refused(outcome, "stiction", "gravity", "coulomb", "friction")
    assert not out.exists()


def test_joints_are_matched_by_name(model: Path, tmp_path: Path) -> None:
    time, q, qd, qdd = motion(5.0, 100.0, 0.8)
    order = [1, 0, 0]
    mixed = Trajectory(
        time, q[:, order], qd[:, order], qdd[:, order], ("elbow", "shoulder", "gripper")
    )
    write_trajectory(tmp_path / "mixed.csv", mixed)
    plain = trajectory(tmp_path / "plain.csv")
    for source in (plain, tmp_path / "mixed.csv"):
        out = source.with_suffix(".out.csv")
        outcome = lagrangian_ff("feedforward", model, source, "--output", out)
        assert outcome.code == 0, outcome
    assert "note: gripper: not in the model, left out" in outcome.text
    assert (tmp_path / "mixed.out.csv").read_text() == (tmp_path / "plain.out.csv").read_text()


def test_a_trajectory_that_leaves_the_identified_range(model: Path, tmp_path: Path) -> None:
    time, q, qd, qdd = motion(5.0, 100.0, 0.5)
    q[200:300, 1] += 3.0
    write_trajectory(tmp_path / "t.csv", Trajectory(time, q, qd, qdd, JOINTS))
    outcome = lagrangian_ff(
        "feedforward", model, tmp_path / "t.csv", "--output", tmp_path / "o.csv", "--json", "-"
    )
    assert outcome.code == 0
    record = json.loads(outcome.out)
    assert record["outside_range"] == pytest.approx(0.2)
    assert record["outside_spans"] == [[2.0, 2.99]]
    assert "position of elbow" in outcome.text
    assert "2.00 to 2.99 s" in outcome.text


def test_positions_alone_are_completed_and_said(model: Path, tmp_path: Path) -> None:
    time, q, _, _ = motion(5.0, 20.0, 0.5)
    rows = [",".join(map(repr, [float(t), *map(float, p)])) for t, p in zip(time, q, strict=True)]
    source = tmp_path / "t.csv"
    source.write_text("\n".join(["time,position/shoulder,position/elbow", *rows]))
    outcome = lagrangian_ff("feedforward", model, source, "--output", tmp_path / "o.csv")
    assert outcome.code == 0, outcome
    assert "note: " in outcome.text
    assert "spline" in outcome.text


def test_bad_trajectories(model: Path, tmp_path: Path) -> None:
    out = tmp_path / "torque.csv"
    late = trajectory(tmp_path / "late.csv")
    lines = late.read_text().splitlines()
    late.write_text("\n".join([*lines[:5], lines[3], *lines[5:]]))
    nan = trajectory(tmp_path / "nan.csv")
    nan.write_text(nan.read_text().replace("\n0.03,", "\nnan,"))
    other = trajectory(tmp_path / "other.csv", joints=("shoulder", "wrist"))
    (tmp_path / "empty.csv").write_text("")
    for source, words in (
        (late, ("late.csv", "line 6", "time")),
        (nan, ("nan.csv", "line 5", "time")),
        (other, ("other.csv", "model.npz", "elbow", "wrist")),
        (tmp_path / "empty.csv", ("empty.csv",)),
        (tmp_path / "none.csv", ("none.csv", "no such file")),
    ):
        assert_refused(lagrangian_ff("feedforward", model, source, "--output", out), *words)
    assert not out.exists()


def test_the_trajectory_is_never_overwritten(model: Path, tmp_path: Path) -> None:
    source = trajectory(tmp_path / "t.csv")
    before = source.read_bytes()
    assert_refused(lagrangian_ff("feedforward", model, source, "--output", source, "--force"))
    assert source.read_bytes() == before
    out = tmp_path / "torque.csv"
    out.write_text("precious")
    assert_refused(lagrangian_ff("feedforward", model, source, "--output", out), "exists already")
    assert out.read_text() == "precious"
