"""`calibrate` through the command line, on the simulated arm with hidden gains."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cli_examples import lagrangian_ff

from lagrangian_ff.arm import JOINTS, Load, exciting_trajectory, robot_description, simulate
from lagrangian_ff.recording import write_csv

pytest.importorskip("pinocchio", reason="Pinocchio, the extra urdf, is not installed")

GAINS = np.array([1.15, 0.8, 1.25, 0.9, -1.05, 0.85])


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Path]:
    """Return recordings whose effort is in hidden units, and the arm's description."""
    folder = tmp_path_factory.mktemp("calibrate")
    found = {"urdf": folder / "arm.urdf"}
    found["urdf"].write_text(robot_description())
    for name, seed, load in (("empty", 1, None), ("carrying", 3, Load(2.5, (0.03, -0.02, 0.1)))):
        loads = {"link_6": load} if load else None
        run = simulate(exciting_trajectory(4, seed, 14.0), loads=loads, seed=seed)
        recording = replace(run.recording, effort=run.recording.effort / GAINS)
        found[name] = write_csv(folder / f"{name}.csv", recording)
    return found


def test_hidden_gains_are_found(files: Mapping[str, Path], tmp_path: Path) -> None:
    out = tmp_path / "gains.json"
    done = lagrangian_ff(
        "calibrate", files["empty"], files["carrying"], "--payload", "2.5", "--urdf", files["urdf"],
        "--json", out,
    )  # fmt: skip
    assert done.code == 0, done.err
    found = json.loads(out.read_text())
    each = [found["joints"][joint] for joint in JOINTS]
    assert [one["gain"] for one in each] == pytest.approx(GAINS.tolist(), rel=0.05)
    assert sum(one["low"] <= g <= one["high"] for one, g in zip(each, GAINS, strict=True)) >= 4
    assert found["payload_centre"] == pytest.approx([0.03, -0.02, 0.1], abs=0.01)
    assert set(found["effort_scale"]) == set(JOINTS)
    option = done.text.partition("--effort-scale ")[2].split()
    assert [one.partition("=")[0] for one in option] == list(JOINTS)
    again = lagrangian_ff(
        "calibrate", files["empty"], files["carrying"], "--payload", "2.5", "--urdf", files["urdf"],
        "--effort-scale", *option,
    )  # fmt: skip
    # What was given already is counted in.
    assert again.text.partition("--effort-scale ")[2].split() == option


def test_what_is_missing_is_said(files: Mapping[str, Path]) -> None:
    both = files["empty"], files["carrying"]
    done = lagrangian_ff("calibrate", *both, "--payload", "2.5")
    assert done.code != 0
    assert "lever arms" in done.err
    done = lagrangian_ff("calibrate", *both, "--urdf", files["urdf"])
    assert "--payload is missing" in done.err
    done = lagrangian_ff("calibrate", *both, "--urdf", files["urdf"], "--payload", "0")
    assert "expected a mass in kg above 0" in done.err
    same = lagrangian_ff("calibrate", both[0], both[0], "--urdf", files["urdf"], "--payload", "1")
    assert "both without and with the load" in same.err
