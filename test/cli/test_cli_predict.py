"""`predict`: the error of a model on another recording, and the torques as CSV."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cli_examples import (
    JOINTS,
    Floats,
    arm,
    assert_refused,
    csv,
    lagrangian_ff,
    process,
    small_model,
    tampered,
)

from lagrangian_ff.diagnosis import compare
from lagrangian_ff.identification import Model
from lagrangian_ff.recording import Recording, condition, write_bag


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of a model of the small arm."""
    return small_model(tmp_path_factory.mktemp("predict") / "model.npz")


def columns(path: Path) -> dict[str, Floats]:
    """Return the columns of a CSV by name."""
    lines = path.read_text().splitlines()
    values = np.array([list(map(float, line.split(","))) for line in lines[1:]])
    return dict(zip(lines[0].split(","), values.T, strict=True))


def test_the_error_is_that_of_compare(model: Path, tmp_path: Path) -> None:
    recording = arm(seconds=6.0, reach=0.8)
    bag = write_bag(tmp_path / "bag", recording)
    outcome = process("predict", model, bag, "--json", "-")
    assert outcome.code == 0, outcome
    record = json.loads(outcome.out)
    expected = compare(Model.load(model), condition(recording))
    assert record["rmse"] == pytest.approx(expected.record()["rmse"], rel=1e-6)
    assert set(record["joints"]) == set(JOINTS)
    assert "The model is very good on every joint." in outcome.err


def test_measured_and_predicted_torques_are_written(model: Path, tmp_path: Path) -> None:
    recording = arm(seconds=6.0, reach=0.8)
    out = tmp_path / "torque.csv"
    outcome = lagrangian_ff(
        "predict", model, csv(tmp_path / "a.csv", recording), "--output", out, "--terms"
    )
    assert outcome.code == 0, outcome
    table = columns(out)
    motion = condition(recording)
    assert np.array_equal(table["time"], motion.time)
    for n, joint in enumerate(JOINTS):
        assert np.array_equal(table[f"measured/{joint}"], motion.tau[:, n])
        parts = ("gravity", "inertia", "coriolis", "viscous", "coulomb", "offset")
        total = sum(table[f"{part}/{joint}"] for part in parts)
        assert np.allclose(total, table[f"predicted/{joint}"], atol=1e-6)
        assert np.abs(table[f"predicted/{joint}"] - motion.tau[:, n]).mean() < 0.3


def test_intervals_are_written_and_what_lies_inside_is_told(model: Path, tmp_path: Path) -> None:
    recording = arm(seconds=12.0, reach=0.9)
    source, out = csv(tmp_path / "a.csv", recording), tmp_path / "torque.csv"
    asked = ("--intervals", "--output", out, "--json", "-")
    outcome = lagrangian_ff("predict", model, source, *asked)
    assert outcome.code == 0, outcome
    table, record = columns(out), json.loads(outcome.out)
    for joint in JOINTS:
        low, high = table[f"low/{joint}"], table[f"high/{joint}"]
        assert (low < high).all()
        assert np.allclose(0.5 * (low + high), table[f"predicted/{joint}"])
        inside = (low <= table[f"measured/{joint}"]) & (table[f"measured/{joint}"] <= high)
        assert inside.mean() == pytest.approx(record["covered"][joint], abs=1e-3)
        assert f"{record['covered'][joint]:.0%} of {joint}" in outcome.text
    assert "covered" not in json.loads(lagrangian_ff("predict", model, source, "--json", "-").out)


def test_joints_are_matched_by_name(model: Path, tmp_path: Path) -> None:
    recording = arm(seconds=6.0)
    order = [1, 0, 0]
    more = Recording(
        ("elbow", "gripper", "shoulder"), recording.time, recording.position[:, order],
        recording.velocity[:, order], recording.effort[:, order] * [1.0, np.nan, 1.0],
    )  # fmt: skip
    outcomes = [
        lagrangian_ff("predict", model, csv(tmp_path / name, given), "--json", "-")
        for name, given in (("plain.csv", recording), ("more.csv", more))
    ]
    first, second = (json.loads(outcome.out)["joints"] for outcome in outcomes)
    assert first == second


def test_a_recording_is_treated_as_those_of_the_identification(tmp_path: Path) -> None:
    reversed_ = arm()
    reversed_ = replace(reversed_, effort=-10.0 * reversed_.effort)
    source = csv(tmp_path / "amperes.csv", reversed_)
    scale = ("--effort-scale", "shoulder=-0.1", "elbow=-0.1")
    path = tmp_path / "model.npz"
    outcome = lagrangian_ff(
        "identify", source, "--samples", "60", "--train", "1.0", *scale, "--output", path
    )
    assert outcome.code == 0, outcome
    error = json.loads(lagrangian_ff("predict", path, source, "--json", "-").out)["rmse"]
    assert error < 0.3
    assert "effort scale in N·m per unit: shoulder -0.100" in lagrangian_ff("info", path).text
    other = ("--effort-scale", "shoulder=0.1", "elbow=0.1")
    wrong = json.loads(lagrangian_ff("predict", path, source, "--json", "-", *other).out)["rmse"]
    assert wrong > 10.0


def test_motion_outside_the_identified_range_is_noted(model: Path, tmp_path: Path) -> None:
    source = csv(tmp_path / "wide.csv", arm(seconds=6.0, reach=1.6))
    outcome = lagrangian_ff("predict", model, source)
    assert outcome.code == 0
    assert "lies outside what the model was identified on" in outcome.text
    inside = lagrangian_ff("predict", model, csv(tmp_path / "in.csv", arm(6.0, reach=0.8)))
    assert "lies outside" not in inside.text


def test_a_recording_of_other_joints(model: Path, tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm(4.0, joints=("shoulder", "wrist")))
    outcome = lagrangian_ff("predict", model, source, "--output", tmp_path / "torque.csv")
    assert_refused(outcome, "model.npz", "arm.csv", "elbow", "wrist")
    assert not (tmp_path / "torque.csv").exists()


def test_a_model_file_that_cannot_be_used(model: Path, tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm(4.0))
    newer = tampered(model, tmp_path / "newer.npz", version=99)
    cut = tmp_path / "cut.npz"
    cut.write_bytes(model.read_bytes()[:3000])
    (tmp_path / "text.npz").write_text("hello")
    strange = tampered(model, tmp_path / "strange.npz", joints=["only one"])
    for path, words in (
        (newer, ("newer.npz", "version 99", "update")),
        (cut, ("cut.npz", "damaged")),
        (tmp_path / "text.npz", ("text.npz",)),
        (strange, ("strange.npz", "damaged")),
        (tmp_path / "none.npz", ("none.npz",)),
        (tmp_path, (str(tmp_path), "folder")),
        (csv(tmp_path / "other.csv", arm(4.0)), ("other.csv",)),
    ):
        assert_refused(lagrangian_ff("predict", path, source), *words)


def test_outputs_are_not_overwritten_and_never_the_inputs(model: Path, tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm(4.0))
    before = source.read_bytes()
    out = tmp_path / "torque.csv"
    out.write_text("precious")
    outcome = lagrangian_ff("predict", model, source, "--output", out)
    assert_refused(outcome, "torque.csv", "exists already")
    assert out.read_text() == "precious"
    assert_refused(lagrangian_ff("predict", model, source, "--output", source, "--force"))
    assert source.read_bytes() == before
    assert lagrangian_ff("predict", model, source, "--output", out, "--force").code == 0
    assert out.read_text().startswith("time,measured/shoulder,")


def test_terms_without_a_file_to_write_them_to(model: Path, tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm(4.0))
    assert_refused(lagrangian_ff("predict", model, source, "--terms"), "--output")
