"""`simulate`: the arm along a motion, with and without torque, as a bag."""

import json
from pathlib import Path

import numpy as np
import pytest
from cli_examples import assert_refused, lagrangian_ff, process, small_model

pytest.importorskip("pybullet", reason="PyBullet is not installed")

from arm_examples import move_to

from lagrangian_ff.arm import (
    HOME,
    JOINTS,
    Trajectory,
    read_trajectory,
    true_torque,
    write_trajectory,
)
from lagrangian_ff.recording import load


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of a motion of a second or two from the arm's home."""
    path = tmp_path_factory.mktemp("simulate") / "short.csv"
    goal = np.array(HOME) + np.array([0.3, 0.1, -0.2, 0.3, 0.2, -0.4])
    move = move_to(HOME, goal)
    time = np.append(np.arange(0.0, move.duration, 0.02), move.duration)
    write_trajectory(path, Trajectory(time, *move.sample(time)))
    return path


def rms(*arguments: str | Path) -> float:
    """Simulate, and return the tracking error in rad."""
    outcome = lagrangian_ff("simulate", *arguments, "--json", "-")
    assert outcome.code == 0, outcome
    record = json.loads(outcome.out)
    assert list(record["joints"]) == list(JOINTS)
    return float(record["rms"])


def test_the_bag_holds_what_the_arm_did(short: Path, tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    outcome = process("simulate", "--trajectory", short, "--output", bag)
    assert outcome.code == 0, outcome
    assert "rms [mrad]" in outcome.out
    assert f"lagrangian_ff identify {bag}" in outcome.out
    recording = load(bag)
    reference = read_trajectory(short)
    assert recording.joints == JOINTS
    assert recording.time[-1] == pytest.approx(reference.duration, abs=0.003)
    assert np.abs(recording.position - reference.sample(recording.time)[0]).max() < 0.2
    assert np.isfinite(recording.effort).all()


def test_true_torque_tracks_better_and_the_torque_can_come_from_a_file(
    short: Path, tmp_path: Path
) -> None:
    none = rms("--trajectory", short, "--output", tmp_path / "none")
    true = rms("--trajectory", short, "--feedforward", "true", "--output", tmp_path / "true")
    assert true < 0.3 * none
    t = read_trajectory(short)
    effort = true_torque(t.q, t.qd, t.qdd)
    torque = tmp_path / "torque.csv"
    write_trajectory(torque, Trajectory(t.time, t.q, t.qd, t.qdd, t.joints, effort))
    file = rms("--feedforward", torque, "--output", tmp_path / "file")
    assert file == pytest.approx(true, rel=0.3)


def test_an_exciting_motion_is_made_and_saved(tmp_path: Path) -> None:
    saved = tmp_path / "t.csv"
    arguments = ("--speed", "2", "--duration", "4", "--seed", "3")
    first = rms(*arguments, "--output", tmp_path / "one", "--save-trajectory", saved)
    assert read_trajectory(saved).duration == pytest.approx(4.0, abs=0.1)
    again = rms("--trajectory", saved, "--seed", "3", "--output", tmp_path / "two")
    assert again == pytest.approx(first, rel=1e-6)


def test_loads_change_what_the_arm_needs(short: Path, tmp_path: Path) -> None:
    errors = [
        rms("--trajectory", short, "--output", tmp_path / str(n), *loads)
        for n, loads in enumerate(
            ((), ("--loads", "paper"), ("--loads", "joint_1=2.5", "joint_2=1"))
        )
    ]
    assert errors[1] == errors[2]
    assert errors[0] != errors[1]


def test_hidden_physics_is_in_the_arm_and_not_in_its_motion(short: Path, tmp_path: Path) -> None:
    efforts = []
    for name, hidden in (("plain", ()), ("odd", ("--hidden", "stribeck@joint_1:0.5"))):
        bag = tmp_path / name
        outcome = lagrangian_ff(
            "simulate", "--trajectory", short, *hidden, "--output", bag, "--json", "-"
        )
        assert outcome.code == 0, outcome
        record = json.loads(outcome.out)["hidden"]
        efforts.append(load(bag).effort[:, 0])
    assert [(one["effect"], one["joint"]) for one in record] == [("stribeck", "joint_1")]
    assert "stribeck on joint_1" in outcome.text
    assert np.abs(efforts[1] - efforts[0]).max() > 1.0


def test_what_cannot_be_driven(short: Path, tmp_path: Path) -> None:
    t = read_trajectory(short)
    files = {
        "fast.csv": Trajectory(t.time / 20.0, t.q, 20.0 * t.qd, 400.0 * t.qdd, t.joints),
        "other.csv": Trajectory(t.time, t.q, t.qd, t.qdd, tuple("abcdef")),
        "elsewhere.csv": Trajectory(t.time, t.q + 0.1, t.qd, t.qdd, t.joints, 0.0 * t.q),
    }
    for name, trajectory in files.items():
        write_trajectory(tmp_path / name, trajectory)
    model = small_model(tmp_path / "small.npz", "--model", "none+fri")
    for arguments, words in (
        (("--trajectory", tmp_path / "fast.csv"), ("fast.csv", "velocity", "joint_")),
        (("--trajectory", tmp_path / "other.csv"), ("other.csv", "joint_1")),
        (("--trajectory", tmp_path / "none.csv"), ("none.csv", "no such file")),
        (("--trajectory", short, "--speed", "3"), ("--trajectory", "--speed")),
        (("--trajectory", short, "--feedforward", tmp_path / "elsewhere.csv"),
         ("elsewhere.csv", "another motion", "0.000 s")),
        (("--trajectory", short, "--feedforward", short), ("short.csv", "effort")),
        (("--trajectory", short, "--feedforward", model), ("small.npz", "elbow", "joint_1")),
        (("--trajectory", short, "--feedforward", "some"), ("--feedforward some", "none, true")),
        (("--trajectory", short, "--feedforward", "no.npz"), ("no.npz", "no such file")),
        (("--trajectory", short, "--loads", "joint_9=1"), ("joint_9",)),
        (("--trajectory", short, "--loads", "joint_1=-1"), ("joint_1", "-1")),
        (("--trajectory", short, "--loads", "joint_1"), ("--loads joint_1", "joint=number")),
        (("--hidden", "stribeck@joint_1"), ("hidden stribeck@joint_1", "stribeck@joint_3:0.1")),
        (("--hidden", "stick@joint_1:0.1"), ("no effect 'stick'", "stribeck, ")),
        (("--hidden", "payload@joint_1:0.1"), ("payload can be on joint_2",)),
        (("--hidden", "stribeck@joint_1:-1"), ("above 0",)),
        (("--duration", "1"), ("duration", "4 s")),
    ):  # fmt: skip
        outcome = lagrangian_ff("simulate", "--output", tmp_path / "bag", *arguments)
        assert_refused(outcome, *words)
    assert not (tmp_path / "bag").exists()


def test_only_bags_are_replaced(short: Path, tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    arguments = ("simulate", "--trajectory", short, "--output", bag)
    bag.mkdir()
    (bag / "thesis.tex").write_text("precious")
    assert_refused(lagrangian_ff(*arguments), "bag", "exists already")
    assert_refused(lagrangian_ff(*arguments, "--force"), "bag", "not replaced")
    assert (bag / "thesis.tex").read_text() == "precious"
    (bag / "thesis.tex").unlink()
    assert lagrangian_ff(*arguments, "--force").code == 0
    assert_refused(lagrangian_ff(*arguments), "exists already")
    assert lagrangian_ff(*arguments, "--force").code == 0
    assert load(bag).joints == JOINTS
    assert [path.name for path in tmp_path.iterdir()] == ["bag"]
