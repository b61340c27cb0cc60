"""`info`: what a recording or a model holds."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cli_examples import (
    JOINTS,
    arm,
    assert_refused,
    csv,
    lagrangian_ff,
    process,
    small_model,
    tampered,
)

from lagrangian_ff.cli.commands.info import is_model
from lagrangian_ff.identification import Model
from lagrangian_ff.recording import write_bag, write_npz


def test_a_recording(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", arm(4.0))
    outcome = process("info", bag)
    assert outcome.code == 0, outcome
    for words in ("/joint_states", "400 samples", "100 Hz", "shoulder: ", "can be identified from"):
        assert words in outcome.out


def test_the_record_of_a_recording(tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm(4.0))
    record = json.loads(lagrangian_ff("info", source, "--json", "-").out)
    assert (record["kind"], record["samples"], record["usable"]) == ("recording", 400, True)
    assert [joint["name"] for joint in record["joints"]] == list(JOINTS)
    assert record["rate"] == pytest.approx(100.0)


def test_a_recording_that_cannot_be_used_is_still_shown(tmp_path: Path) -> None:
    recording = arm(4.0)
    recording.effort[:] = np.nan
    source = csv(tmp_path / "arm.csv", recording)
    outcome = lagrangian_ff("info", source, "--json", tmp_path / "found.json")
    assert outcome.code == 0
    assert "cannot be identified from as it is: " in outcome.text
    assert "no effort" in outcome.text
    record = json.loads((tmp_path / "found.json").read_text())
    assert record["usable"] is False
    assert "effort" in record["reason"]


def test_what_a_recording_could_show(tmp_path: Path) -> None:
    recording = arm()
    recording.effort[:] += np.random.default_rng(0).normal(size=recording.effort.shape)
    source = csv(tmp_path / "arm.csv", recording)
    outcome = lagrangian_ff("info", source, "--observable", "--json", tmp_path / "found.json")
    assert outcome.code == 0, outcome
    text = " ".join(outcome.text.split())
    assert "what this motion could show" in text
    assert "the motion to do" in text
    found = json.loads((tmp_path / "found.json").read_text())["observable"]
    assert found["words"] in text
    assert set(found["least"]["stribeck"]) == set(JOINTS)
    hidden = {(one["effect"], one["joint"]) for one in found["not_observable"]}
    for effect, row in found["least"].items():
        for joint, least in row.items():
            assert ((effect, joint) in hidden) == (least is None or least > found["size"])


def test_a_model_is_no_motion_to_observe(tmp_path: Path) -> None:
    model = small_model(tmp_path / "model.npz")
    assert_refused(lagrangian_ff("info", model, "--observable"), "not at a model")


def test_the_page_shows_the_spectra_behind_the_bandwidth(tmp_path: Path) -> None:
    source, page = csv(tmp_path / "arm.csv", arm()), tmp_path / "arm.html"
    outcome = lagrangian_ff("info", source, "--report", page, "--json", tmp_path / "found.json")
    assert outcome.code == 0, outcome
    chosen = json.loads((tmp_path / "found.json").read_text())["bandwidth"]
    assert f"bandwidth {chosen:g} Hz: " in " ".join(outcome.text.split())
    text = page.read_text()
    for joint in JOINTS:
        assert f"spectrum of the torque of {joint}" in text
    assert f"Bandwidth {chosen:g} Hz: " in text
    model = small_model(tmp_path / "model.npz")
    assert_refused(lagrangian_ff("info", model, "--report", page, "--force"), "not of a model")


def test_another_unit_is_named_with_the_option_that_converts_it(tmp_path: Path) -> None:
    right = arm()
    degrees = replace(right, velocity=np.degrees(right.velocity))
    source = csv(tmp_path / "arm.csv", degrees)
    outcome = lagrangian_ff("info", source, "--json", tmp_path / "found.json")
    assert "the derivative of position: it is in deg/s" in " ".join(outcome.text.split())
    (doubt,) = json.loads((tmp_path / "found.json").read_text())["doubts"]
    assert doubt["remedy"] == "--units velocity=deg/s converts it"
    mended = lagrangian_ff("info", source, "--units", "velocity=deg/s")
    assert "times the derivative" not in mended.text
    assert "converted as asked: velocity from deg/s" in " ".join(mended.text.split())


def test_stamps_in_nanoseconds_are_refused_with_the_option_that_reads_them(tmp_path: Path) -> None:
    right = arm()
    source = csv(tmp_path / "arm.csv", replace(right, time=np.round(1e9 * right.time), start=0.0))
    outcome = lagrangian_ff("info", source)
    assert "--units time=ns" in outcome.text
    assert "cannot be identified from as it is" in outcome.text
    assert "can be identified from: " in lagrangian_ff("info", source, "--units", "time=ns").text


def test_a_model(tmp_path: Path) -> None:
    path = small_model(tmp_path / "model.npz")
    outcome = lagrangian_ff("info", path)
    assert outcome.code == 0, outcome
    for words in (
        "model chain+fri of shoulder, elbow", "model.csv", "in words", "τ = ", "inertia",
        "weight of the joints' motion", "torque scale", "the mass matrix is positive definite",
        "the motion it was identified on", "speed [rad/s]",
    ):  # fmt: skip
        assert words in outcome.text
    record = json.loads(lagrangian_ff("info", path, "--json", "-").out)
    assert record["kind"] == "model"
    assert record["joint_names"] == list(JOINTS)
    model = Model.load(path)
    assert {name: record[name] for name in model.record} == model.record


def test_a_model_with_a_record_of_another_kind(tmp_path: Path) -> None:
    path = small_model(tmp_path / "model.npz", "--model", "none+fri")
    outcome = lagrangian_ff("info", tampered(path, tmp_path / "bare.npz", record={}))
    assert outcome.code == 0
    assert "note: the model's record has no model, samples" in outcome.text
    assert "the motion it was identified on" in outcome.text


def test_models_are_told_from_recordings(tmp_path: Path) -> None:
    recording = write_npz(tmp_path / "arm.npz", arm(4.0))
    text = tmp_path / "text.npz"
    text.write_text("hello")
    assert is_model(small_model(tmp_path / "model.npz", "--model", "none+fri"))
    assert not any(map(is_model, (recording, text, tmp_path, tmp_path / "none.npz")))
    assert "400 samples" in lagrangian_ff("info", recording).out


def test_what_is_neither(tmp_path: Path) -> None:
    (tmp_path / "text.npz").write_text("hello")
    (tmp_path / "notes.txt").write_text("hello")
    assert_refused(lagrangian_ff("info", tmp_path / "text.npz"), "text.npz", "nor is it a model")
    assert_refused(lagrangian_ff("info", tmp_path / "notes.txt"), "notes.txt", "not a recording")
    assert_refused(lagrangian_ff("info", tmp_path / "none"), "none", "no such file")
