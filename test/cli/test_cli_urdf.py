"""`identify --urdf`: a known robot from the command line."""

import json
from pathlib import Path

import numpy as np
import pytest
from cli_examples import QUICK, arm, assert_refused, csv, lagrangian_ff, motion, torque
from mechanism_examples import pendulum_urdf

from lagrangian_ff.identification import Model


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return csv(tmp_path_factory.mktemp("urdf") / "arm.csv", arm())


def urdf(folder: Path, gripper: str = "") -> Path:
    """The small arm, lengths right, masses only roughly; perhaps with more on it."""
    text = pendulum_urdf(2.0, 1.0).replace('xyz="0.5 0 0"', 'xyz="1 0 0"')
    path = folder / "arm.urdf"
    path.write_text(text.replace("</robot>", f"{gripper}</robot>"))
    return path


def test_the_bodies_of_a_urdf_become_part_of_the_model(recording: Path, tmp_path: Path) -> None:
    pytest.importorskip("pinocchio", reason="Pinocchio, the extra urdf, is not installed")
    finger = (
        '<link name="finger"/><joint name="grip" type="prismatic"><parent link="lower"/>'
        '<child link="finger"/><limit lower="0" upper="1" velocity="1" effort="1"/></joint>'
    )
    outcome = lagrangian_ff(
        "identify", recording, *QUICK, "--train", "0.3", "--urdf", urdf(tmp_path, finger),
        "--output", tmp_path / "model.npz", "--json", tmp_path / "found.json",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    assert "the bodies of pendulum are known (3.00 kg)" in outcome.text
    assert "not recorded and taken to stand at zero: grip" in outcome.text
    assert "how far masses may be from the URDF's" in outcome.text
    assert json.loads((tmp_path / "found.json").read_text())["mechanism"]["still"] == ["grip"]
    model = Model.load(tmp_path / "model.npz")
    _, q, qd, qdd = motion(5.0, 50.0, reach=0.7)
    error = model.predict(q, qd, qdd) - torque(q, qd, qdd)
    assert np.sqrt(np.mean(error**2)) < 0.2  # of 15 N·m
    told = lagrangian_ff("info", tmp_path / "model.npz")
    assert "the bodies of pendulum are known" in told.text


def test_bad_descriptions_are_refused_before_any_work(recording: Path, tmp_path: Path) -> None:
    broken, output = tmp_path / "broken.urdf", tmp_path / "model.npz"
    broken.write_text("<robot><link></robot>")
    outcome = lagrangian_ff("identify", recording, "--urdf", broken, "--output", output)
    assert_refused(outcome, "broken.urdf is no URDF", "not XML")
    outcome = lagrangian_ff("identify", recording, "--urdf", tmp_path / "no", "--output", output)
    assert_refused(outcome, "no URDF file")
    same = lagrangian_ff("identify", recording, "--urdf", output, "--output", output)
    assert same.code == 2


def test_other_joints_are_refused_with_both_lists(recording: Path, tmp_path: Path) -> None:
    pytest.importorskip("pinocchio", reason="Pinocchio, the extra urdf, is not installed")
    path = urdf(tmp_path)
    path.write_text(path.read_text().replace('"elbow"', '"knee"'))
    outcome = lagrangian_ff(
        "identify", recording, "--urdf", path, "--output", tmp_path / "model.npz"
    )
    assert_refused(outcome, "has no elbow", "recorded: shoulder, elbow", "shoulder, knee")
    assert not (tmp_path / "model.npz").exists()
