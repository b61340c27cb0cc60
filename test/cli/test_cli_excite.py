"""`excite`: motions as files that the simulated arm and ROS can follow."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_examples import assert_refused, lagrangian_ff, small_model
from numpy.typing import NDArray
from ruamel.yaml import YAML

from lagrangian_ff.arm import JOINTS, Trajectory, read_trajectory, simulate, true_torque
from lagrangian_ff.cli.common import arm_motion
from lagrangian_ff.cli.common.joint_trajectory import CLOSE, joint_trajectory_yaml
from lagrangian_ff.diagnosis.excite import NEXT_MOTIONS
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import ArmError
from lagrangian_ff.identification import Model

Floats = NDArray[np.float64]


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a model of the small arm."""
    return small_model(tmp_path_factory.mktemp("model") / "model.npz")


def parsed(text: str) -> dict[str, Any]:
    """The message, by the YAML 1.1 that ros2cli reads."""
    reader = YAML(typ="safe", pure=True)
    reader.version = (1, 1)
    found = reader.load(text)
    assert isinstance(found, dict)
    return found


def values(message: dict[str, Any], name: str) -> Floats:
    """One array of all points of a JointTrajectory."""
    points = message["points"]
    assert isinstance(points, list)
    return np.array([point[name] for point in points], dtype=np.float64)


@pytest.mark.parametrize("motion", NEXT_MOTIONS)
def test_a_motion_stays_within_what_the_model_knows(
    model: Path, tmp_path: Path, motion: str
) -> None:
    output = tmp_path / "motion.csv"
    outcome = lagrangian_ff(
        "excite", motion, "--joint", "elbow", "--model", model, "--output", output,
        "--duration", "20", "--json", "-",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    record = json.loads(outcome.out)
    assert record["motion"] == motion
    assert NEXT_MOTIONS[motion].meaning in " ".join(outcome.err.split())
    known = Model.load(model).range
    found = read_trajectory(output)
    assert found.joints == ("shoulder", "elbow")
    assert np.all((found.q >= known.q_low) & (found.q <= known.q_high))
    assert np.all(np.abs(found.qd) <= known.qd_max)
    assert np.all(np.abs(found.qdd) <= known.qdd_max)
    assert np.ptp(found.q[:, 1]) > 0.0


@pytest.mark.parametrize("effect", ["stribeck", "delay", "coupled"])
def test_an_effect_names_its_motion(model: Path, tmp_path: Path, effect: str) -> None:
    output = tmp_path / "motion.csv"
    outcome = lagrangian_ff("excite", effect, "--model", model, "--output", output)
    assert outcome.code == 0, outcome
    assert outcome.out.startswith(f"{EFFECTS[effect].motion}, for {effect}: all joints, ")
    assert "cannot know" in outcome.text


@pytest.mark.parametrize("name", ["slow sweep", "slow-sweep", "slow_sweep", "Slow Sweep"])
def test_names_with_blanks(model: Path, tmp_path: Path, name: str) -> None:
    outcome = lagrangian_ff("excite", name, "--model", model, "--output", tmp_path / "m.csv")
    assert outcome.code == 0, outcome
    assert outcome.out.startswith("slow sweep")


def test_the_start_and_the_reach(model: Path, tmp_path: Path) -> None:
    output = tmp_path / "m.csv"
    outcome = lagrangian_ff(
        "excite", "exciting", "--model", model, "--output", output, "--reach", "0.2",
        "--start", "shoulder=0.1", "elbow=-0.1", "--duration", "15", "--seed", "3",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    found = read_trajectory(output)
    for end in (0, -1):
        np.testing.assert_allclose(found.q[end], [0.1, -0.1], atol=1e-9)
    known = Model.load(model).range
    assert np.all(np.ptp(found.q, axis=0) <= 0.2 * (known.q_high - known.q_low))


def test_a_joint_trajectory_for_ros(model: Path, tmp_path: Path) -> None:
    """The same motion: its quintics, through fewer points."""
    files = {suffix: tmp_path / f"m{suffix}" for suffix in (".csv", ".yaml")}
    for path in files.values():
        outcome = lagrangian_ff(
            "excite", "speeds", "--joint", "elbow", "--model", model, "--output", path
        )
        assert outcome.code == 0, outcome
    assert f"--stdin < {files['.yaml']}" in outcome.out
    message = parsed(files[".yaml"].read_text())
    assert set(message) == {"joint_names", "points"}
    assert all(
        isinstance(value, float)
        for point in message["points"]
        for name in ("positions", "velocities", "accelerations")
        for value in point[name]
    )
    since = [point["time_from_start"] for point in message["points"]]
    time = np.array([one["sec"] + 1e-9 * one["nanosec"] for one in since])
    thin = Trajectory(
        time,
        values(message, "positions"),
        values(message, "velocities"),
        values(message, "accelerations"),
        tuple(message["joint_names"]),
    )
    full = read_trajectory(files[".csv"])
    assert len(thin) < 0.5 * len(full)
    assert thin.time[0] == 0.0
    assert thin.time[-1] == pytest.approx(full.duration)
    np.testing.assert_allclose(thin.sample(full.time)[0], full.q, atol=2 * CLOSE)


def test_small_numbers_stay_numbers() -> None:
    """YAML takes 1e-05 for a text, and ROS refuses 1 where it wants 1.0."""
    q = np.array([[1.0, 1.23e-7], [2.0, -4.5e-6]])
    text = joint_trajectory_yaml(
        Trajectory(np.array([0.0, 1.0]), q, 0.0 * q, 0.0 * q, ("a", "b")), "two points"
    )
    found = values(parsed(text), "positions")
    assert found.dtype == np.float64
    np.testing.assert_allclose(found, q, rtol=1e-5)
    assert "[1.0, 0.000000123]" in text


@pytest.mark.parametrize(("name", "joint"), [("reversals", "joint_2"), ("chirp", "joint_5")])
def test_the_simulated_arm_follows(tmp_path: Path, name: str, joint: str) -> None:
    output = tmp_path / "m.csv"
    outcome = lagrangian_ff(
        "excite", name, "--joint", joint, "--arm", "--output", output, "--duration", "6"
    )
    assert outcome.code == 0, outcome
    assert f"simulate --trajectory {output}" in outcome.out
    run = simulate(read_trajectory(output), "true")
    assert not run.saturated.any()
    assert np.abs(run.tracking_error).max() < 0.05


@pytest.mark.parametrize("name", NEXT_MOTIONS)
def test_every_motion_of_the_arm_is_clear(tmp_path: Path, name: str) -> None:
    """It is looked for until it touches nothing: `clear_motion` asks the arm itself."""
    output = tmp_path / "m.csv"
    outcome = lagrangian_ff(
        "excite", name, "--arm", "--joint", "joint_3", "--output", output, "--duration", "12"
    )
    assert outcome.code == 0, outcome
    found = read_trajectory(output)
    assert found.joints == JOINTS
    assert np.ptp(found.q[:, 2]) > 1e-3


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ["stribek", "--arm", "--output", "m.csv"],
            ["'stribek'", "mean stribeck or", "slow sweep"],
        ),
        (["chirp", "--arm", "--output", "m.txt"], ["m.txt", ".csv or .yaml"]),
        (["chirp", "--arm", "--output", "m.csv", "--joint", "elbow"], ["elbow", "joint_1"]),
        (["chirp", "--arm", "--output", "m.csv", "--start", "elbow=1"], ["elbow", "joint_1"]),
        (["chirp", "--arm", "--output", "m.csv", "--start", "joint_1=9"], ["joint_1 at 9 rad"]),
        (["chirp", "--arm", "--output", "m.csv", "--reach", "2"], ["--reach 2", "1 at most"]),
        (["chirp", "--arm", "--output", "m.csv", "--duration", "1"], ["1 s", "5 to 3600"]),
        (["chirp", "--model", "none.npz", "--output", "m.csv"], ["none.npz"]),
        (["chirp", "--output", "m.csv"], ["--model", "--arm"]),
    ],
)
def test_mistakes(
    arguments: list[str], words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert_refused(lagrangian_ff("excite", *arguments), *words)
    assert not list(tmp_path.iterdir())


def test_nothing_is_replaced(model: Path, tmp_path: Path) -> None:
    output = tmp_path / "m.csv"
    output.write_text("mine")
    again = lagrangian_ff("excite", "chirp", "--model", model, "--output", output)
    assert_refused(again, "m.csv", "exists already")
    assert output.read_text() == "mine"


def test_the_motion_shrinks_until_it_is_clear(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """This arm touches nothing within its limits; let there be a wall."""
    looked: list[float] = []

    def wall(trajectory: Trajectory, *_: object) -> None:
        looked.append(float(np.ptp(trajectory.q[:, 2])))
        if looked[-1] > farthest:
            raise ArmError("trajectory: link_4 and the wall touch at 2.00 s")

    monkeypatch.setattr("lagrangian_ff.cli.common.arm_motion.check_clearance", wall)
    output = tmp_path / "m.csv"
    command = ["excite", "slow sweep", "--arm", "--joint", "joint_3", "--duration", "12"]
    farthest = 1.0
    outcome = lagrangian_ff(*command, "--output", output)
    assert outcome.code == 0, outcome
    assert looked[0] > farthest
    assert 0.4 < np.ptp(read_trajectory(output).q[:, 2]) <= farthest
    farthest = 0.0
    outcome = lagrangian_ff(*command, "--output", tmp_path / "none.csv", "--start", "joint_2=0.3")
    assert_refused(outcome, "link_4 and the wall touch", "name another start", "--reach")


def test_the_motion_slows_down_until_the_torque_suffices() -> None:
    limits = np.array([130.0, 180.0, 100.0, 40.0, 25.0, 15.0])
    found = arm_motion.clear_motion("speeds", "joint_1", duration=15.0)
    torque = true_torque(found.q, found.qd, found.qdd)
    assert np.all(np.abs(torque) <= arm_motion.USED_EFFORT * limits * 1.01)
