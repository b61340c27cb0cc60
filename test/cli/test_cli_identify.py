"""`identify`: what it writes, what it tells, and that it refuses early."""

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from cli_examples import (
    COULOMB,
    JOINTS,
    QUICK,
    VISCOUS,
    Outcome,
    arm,
    assert_refused,
    csv,
    lagrangian_ff,
    motion,
    process,
    torque,
)

from lagrangian_ff.cli.commands.identify import EPILOG
from lagrangian_ff.cli.main import build_parser
from lagrangian_ff.effects import EFFECTS, GROUPS
from lagrangian_ff.identification import Model, Settings
from lagrangian_ff.identification.settings import CRITERIA, LOSSES, SCALES
from lagrangian_ff.kernels import KERNELS
from lagrangian_ff.recording import Conditioning, Recording, write_bag, write_npz


@pytest.fixture(scope="module")
def identified(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Outcome]:
    """Return a folder with arm.csv, model.npz and found.json, and what was printed."""
    folder = tmp_path_factory.mktemp("identified")
    csv(folder / "arm.csv", arm())
    outcome = lagrangian_ff(
        "identify", folder / "arm.csv", *QUICK, "--train", "0.6",
        "--output", folder / "model.npz", "--json", folder / "found.json",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    return folder, outcome


def test_the_model_predicts_torques_it_has_not_seen(identified: tuple[Path, Outcome]) -> None:
    folder, _ = identified
    model = Model.load(folder / "model.npz")
    _, q, qd, qdd = motion(5.0, 50.0, reach=0.7)
    error = model.predict(q, qd, qdd) - torque(q, qd, qdd)
    assert model.joints == JOINTS
    assert np.sqrt(np.mean(error**2)) < 0.5  # of 15 N·m


def test_the_record_holds_what_the_page_and_the_node_show(identified: tuple[Path, Outcome]) -> None:
    folder, _ = identified
    record = json.loads((folder / "found.json").read_text())
    assert {
        "model", "joints", "rmse", "nmse", "samples", "seconds", "hyperparameters", "effects"
    } <= set(record)  # fmt: skip
    assert record["model"] == "chain+fri"
    assert record["samples"] == 60
    assert set(record["joints"]) == set(JOINTS)
    assert all(set(error) >= {"rmse", "nmse"} for error in record["joints"].values())
    assert 0.0 < record["nmse"] < 0.1
    for effect in record["effects"]:
        assert effect["joint"] in JOINTS
        for found in effect["parameters"].values():
            assert found["low"] <= found["value"] <= found["high"]
            assert found["unit"]
    assert record.pop("preflight") == []  # nothing of the recording contradicts how it was read
    assert dict(Model.load(folder / "model.npz").record) == record


def test_friction_is_found_and_shown_with_numbers(identified: tuple[Path, Outcome]) -> None:
    folder, outcome = identified
    record = json.loads((folder / "found.json").read_text())
    found = {
        (entry["effect"], entry["joint"]): next(iter(entry["parameters"].values()))["value"]
        for entry in record["effects"]
    }
    for n, joint in enumerate(JOINTS):
        assert found["viscous", joint] == pytest.approx(VISCOUS[n], rel=0.3)
        assert found["coulomb", joint] == pytest.approx(COULOMB[n], rel=0.2)
    assert f"τ = {found['viscous', 'shoulder']:.3f} qd + " in outcome.out
    assert "tanh(qd / " in outcome.out
    assert "N·m·s/rad" in outcome.out


def test_the_text_says_what_it_means(identified: tuple[Path, Outcome]) -> None:
    folder, outcome = identified
    for words in (
        "2400 samples in 23.990 s, 100 Hz",
        "note: low-pass",
        "judged on motion after the training part",
        "in words",
        "1 is no better than a constant",
        "90 % intervals",
        "The model is",
        f"saved: {folder / 'model.npz'}",
    ):
        assert words in outcome.text
    assert outcome.text.count("note: low-pass") == 1


def test_it_runs_through_the_entry_point_and_json_can_go_to_stdout(tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm())
    outcome = process(
        "identify", source, *QUICK, "--output", tmp_path / "model.npz", "--json", "-"
    )  # fmt: skip
    assert outcome.code == 0, outcome
    assert json.loads(outcome.out)["settings"]["samples"] == 60
    assert "The model is" in outcome.err
    assert Model.load(tmp_path / "model.npz").joints == JOINTS


def test_every_option_reaches_the_settings(tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm())
    outcome = lagrangian_ff(
        "identify", source, "--output", tmp_path / "model.npz", "--json", "-",
        "--model", "rbf+viscous", "--train", "0.5", "--samples", "50", "--block", "0.8",
        "--folds", "4", "--selection", "evidence", "--scale", "common", "--joints", "elbow",
        "--effort-scale", "elbow=2", "--effort-offset", "elbow=-0.5", "--bandwidth", "12",
        "--rate", "50", "--clock", "stamps", "--landmarks", "30", "--loss", "huber",
        "--effort-delay", "0.004",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    record = json.loads(outcome.out)
    chosen = ("rbf+viscous", 0.5, 50, 0.8, 4, "evidence", "common")
    expected = Settings(*chosen, landmarks=30, loss="huber")
    assert Settings.from_record(record["settings"]) == expected
    conditioning = Conditioning(
        bandwidth=12.0, rate=50.0, clock="stamps", effort_scale={"elbow": 2.0},
        effort_offset={"elbow": -0.5}, effort_delay=0.004,
    )  # fmt: skip
    assert record["conditioning"] == vars(conditioning)
    assert list(record["joints"]) == ["elbow"]
    assert record["outliers"]["words"].split(" ")[0] in outcome.err


def test_a_model_on_inducing_points_says_what_it_learned_from(tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm(seconds=30.0))
    outcome = lagrangian_ff(
        "identify", source, "--output", tmp_path / "model.npz", "--json", tmp_path / "found.json",
        "--samples", "50", "--inducing-points", "30", "--model", "motor+fri",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    record = json.loads((tmp_path / "found.json").read_text())
    assert record["landmarks"] == 30
    assert record["samples"] > 500
    assert f"of {record['samples']} samples" in outcome.out
    assert "the kernel built on 30 of them" in outcome.out


def test_options_left_out_leave_the_defaults_to_the_settings(tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm(seconds=30.0))
    outcome = lagrangian_ff(
        "identify", source, "--output", tmp_path / "model.npz", "--json", "-", "--samples", "50"
    )
    record = json.loads(outcome.out)
    assert record["settings"] == Settings(samples=50).record()
    chosen = record["conditioning"]["bandwidth"]
    assert record["conditioning"] == {**vars(Conditioning()), "bandwidth": chosen}
    assert any(note.startswith(f"bandwidth {chosen:g} Hz: ") for note in record["notes"])


def test_the_help_names_the_defaults_kernels_and_effects_there_are() -> None:
    usual = Settings()
    train = Fraction(usual.train).limit_denominator(10)
    text = " ".join(lagrangian_ff("identify", "--help").out.split())
    for default in (
        usual.model, train, usual.samples, f"{usual.block_seconds:g}", usual.folds,
        usual.selection, usual.scale, usual.loss,
        Conditioning().clock,
    ):  # fmt: skip
        assert f"(default: {default}" in text
    for name in KERNELS:
        assert name in EPILOG
    assert f"fri = {'+'.join(GROUPS['fri'])}" in EPILOG
    assert set(GROUPS["fri"]) <= set(EFFECTS)


@pytest.mark.parametrize(
    ("option", "known"), [("--selection", CRITERIA), ("--scale", SCALES), ("--loss", LOSSES)]
)
def test_choices_are_those_of_the_settings(option: str, known: tuple[str, ...]) -> None:
    for choice in known:
        arguments = build_parser().parse_args(["identify", "x", "--output", "y", option, choice])
        assert choice in vars(arguments).values()


@pytest.mark.parametrize("given", [("b,a",), ("b", "a"), ("b", "--joints", "a")])
def test_joints_are_chosen_and_ordered_by_the_user(given: tuple[str, ...], tmp_path: Path) -> None:
    recording = arm(joints=("a", "b"))
    outcome = lagrangian_ff(
        "identify", csv(tmp_path / "arm.csv", recording), *QUICK,
        "--output", tmp_path / "model.npz", "--model", "none+fri", "--joints", *given,
    )  # fmt: skip
    assert outcome.code == 0, outcome
    assert Model.load(tmp_path / "model.npz").joints == ("b", "a")


def test_several_recordings_of_any_kind_are_learned_from_together(tmp_path: Path) -> None:
    sources = [
        csv(tmp_path / "one.csv", arm(12.0)),
        write_npz(tmp_path / "two.npz", arm(12.0, reach=0.8)),
        write_bag(tmp_path / "three", arm(12.0, reach=0.6)),
    ]
    outcome = lagrangian_ff(
        "identify", *sources, *QUICK, "--train", "1.0",
        "--output", tmp_path / "model.npz", "--json", "-",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    record = json.loads(outcome.out)
    assert len(record["sources"]) == 3
    assert record["training_seconds"] == pytest.approx(3 * 12.0, abs=1.0)
    assert outcome.text.count("1200 samples in 11.990 s") == 3


def test_the_torque_of_a_driver_that_reports_current_is_scaled(tmp_path: Path) -> None:
    recording = arm()
    amperes = Recording(
        JOINTS, recording.time, recording.position, recording.velocity,
        (recording.effort - np.array([0.0, 2.0])) / np.array([10.0, -5.0]),
    )  # fmt: skip
    outcome = lagrangian_ff(
        "identify", csv(tmp_path / "arm.csv", amperes), *QUICK, "--train", "1.0",
        "--effort-scale", "shoulder=10", "elbow=-5", "--effort-offset", "elbow=2",
        "--output", tmp_path / "model.npz",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    model = Model.load(tmp_path / "model.npz")
    _, q, qd, qdd = motion(5.0, 50.0, reach=0.7)
    assert np.abs(model.predict(q, qd, qdd) - torque(q, qd, qdd)).mean() < 0.5


def test_a_held_out_part_outside_the_training_range_is_named_as_the_cause(tmp_path: Path) -> None:
    time, q, qd, qdd = motion(24.0, 100.0)
    wider = np.clip((time - 6.0) / 6.0, 0.0, 1.0)[:, None] * np.array([1.5, 0.0])
    recording = Recording(JOINTS, time, q + wider, qd, torque(q + wider, qd, qdd))
    outcome = lagrangian_ff(
        "identify", csv(tmp_path / "arm.csv", recording), *QUICK, "--train", "0.3",
        "--model", "vrbfs+fri", "--output", tmp_path / "model.npz",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    assert "of the held-out motion lies outside what was trained on" in outcome.text
    assert "position of shoulder" in outcome.text
    assert "--train 1.0" in outcome.text


def test_the_wrong_sign_of_the_effort_is_suspected(tmp_path: Path) -> None:
    time, q, qd, qdd = motion(24.0, 100.0)
    recording = Recording(JOINTS, time, q, qd, -torque(q, qd, qdd))
    outcome = lagrangian_ff(
        "identify", csv(tmp_path / "arm.csv", recording), *QUICK, "--train", "1.0",
        "--output", tmp_path / "model.npz",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    assert "--effort-scale shoulder=-1 elbow=-1" in outcome.text


def test_existing_outputs_are_kept_unless_forced(tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm())
    model, found = tmp_path / "model.npz", tmp_path / "found.json"
    model.write_bytes(b"precious")
    arguments: list[str | Path] = ["identify", source, *QUICK, "--model", "none+fri"]
    arguments += ["--output", model]
    assert_refused(lagrangian_ff(*arguments), str(model), "exists already", "--force")
    assert model.read_bytes() == b"precious"
    found.write_text("precious")
    other = tmp_path / "b.npz"
    outcome = lagrangian_ff("identify", source, *QUICK, "--output", other, "--json", found)
    assert_refused(outcome, str(found), "exists already")
    assert not other.exists()
    assert lagrangian_ff(*arguments, "--force").code == 0
    assert Model.load(model).joints == JOINTS


def test_the_recording_is_never_overwritten(tmp_path: Path) -> None:
    source = write_npz(tmp_path / "arm.npz", arm())
    before = source.read_bytes()
    outcome = lagrangian_ff("identify", source, *QUICK, "--output", source, "--force")
    assert_refused(outcome, str(source))
    assert source.read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--train", "1.5"), ("train", "1.5")),
        (("--train", "0"), ("train",)),
        (("--samples", "3"), ("samples", "3")),
        (("--folds", "1"), ("folds",)),
        (("--block", "0"), ("block",)),
        (("--model", "vrbfz+fri"), ("vrbfz", "vrbfs")),
        (("--model", "vrbfs+rbf"), ("vrbfs", "rbf")),
        (("--bandwidth", "-1"), ("bandwidth", "-1")),
        (("--bandwidth", "wide"), ("--bandwidth", "'wide'", "a number in Hz, or auto")),
        (("--units", "deg"), ("units", "'deg'", "quantity=unit")),
        (("--units", "angle=deg"), ("'angle'", "time, position, velocity, effort")),
        (("--units", "position=grad"), ("'grad'", "rad, deg, mrad")),
        (("--units", "time=ms", "time=s"), ("time", "twice")),
        (("--effort-scale", "elbow"), ("--effort-scale", "joint=number")),
        (("--effort-scale", "elbow=ten"), ("elbow=ten",)),
        (("--effort-scale", "elbow=1", "elbow=2"), ("elbow", "twice")),
        (("--effort-offset", "wrist=1"), ("arm.csv", "wrist", "elbow")),
        (("--joints", "wrist"), ("arm.csv", "wrist", "elbow")),
    ],
)
def test_settings_that_cannot_work_are_refused(
    arguments: tuple[str, ...], words: tuple[str, ...], tmp_path: Path
) -> None:
    source = csv(tmp_path / "arm.csv", arm(seconds=4.0))
    model = tmp_path / "model.npz"
    assert_refused(lagrangian_ff("identify", source, "--output", model, *arguments), *words)
    assert not model.exists()


@pytest.mark.parametrize(
    ("output", "words"),
    [("no/model.npz", ("no folder",)), ("model", (".npz",)), ("folder.npz", ("is a folder",))],
)
def test_a_place_that_cannot_be_written_is_refused_before_any_work(
    output: str, words: tuple[str, ...], tmp_path: Path
) -> None:
    (tmp_path / "folder.npz").mkdir()
    source = csv(tmp_path / "arm.csv", arm(seconds=4.0))
    outcome = lagrangian_ff("identify", source, "--output", tmp_path / output)
    assert_refused(outcome, output, *words)
    assert outcome.out == ""
