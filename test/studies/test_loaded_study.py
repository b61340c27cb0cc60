"""`study loaded`: the masses are there, and the arm without them is that of `study speeds`."""

import json
from pathlib import Path

import numpy as np
import pytest

from lagrangian_ff.arm import true_torque
from lagrangian_ff.arm.description import LOAD_POINTS
from lagrangian_ff.cli.main import main
from lagrangian_ff.studies.arm import LOADS, Drive
from lagrangian_ff.studies.loaded import LoadedStudy
from lagrangian_ff.studies.speeds import SpeedsStudy
from lagrangian_ff.studies.study import Request

GRAVITY = 9.81  # m/s²


def test_at_rest_the_masses_weigh_at_their_levers() -> None:
    """The second axis bears m g r of the ball on link 2; the first is upright and bears none."""
    assert LOADS == {"joint_1": 2.5, "joint_2": 1.0}
    q = np.random.default_rng(0).uniform(-1.0, 1.0, (20, 6))
    still = np.zeros_like(q)
    more = true_torque(q, still, still, loads=LOADS) - true_torque(q, still, still)
    _, _, height = LOAD_POINTS["link_2"]
    expected = np.zeros_like(q)
    expected[:, 1] = -1.0 * GRAVITY * height * np.sin(q[:, 1])
    np.testing.assert_allclose(more, expected, atol=1e-9)


def test_the_loaded_arm_is_recorded_with_its_masses() -> None:
    """Its twin makes the same motion: their motors differ by what the masses need."""
    light, heavy = (Drive(5, 0, 9.0, loaded=loaded).motion() for loaded in (False, True))
    with_, without = (
        true_torque(heavy.q, heavy.qd, heavy.qdd, loads=loads) for loads in (LOADS, None)
    )
    needed = (with_ - without)[:, 1]
    given = (heavy.tau - light.tau)[:, 1]
    assert np.dot(needed, given) / np.dot(needed, needed) == pytest.approx(1.0, abs=0.1)


def test_a_small_one_compares_with_the_arm_without_masses(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["study", "loaded", "--quick", "--jobs", "1", "--output", str(tmp_path)]
    models = ["--models", "motor+fri", "vrbfs+fri"]
    assert main([*command, *models, "--cases", "*05-*"]) == 0
    numbers = json.loads((tmp_path / "summary.json").read_text())
    assert numbers["cases"] == 4
    assert numbers["failed"] == {}
    assert numbers["findings"]["lagrangian_best"]["holds"]
    for name, key in (("loaded", "curves"), ("unloaded", "unloaded")):
        gap = numbers[key]["motor+fri"]["rmse"][0] - numbers[key]["vrbfs+fri"]["rmse"][0]
        assert numbers["findings"]["gap_wider"]["gap"][name] == pytest.approx(gap)
    (light,), (heavy,) = (numbers[key]["motor+fri"]["rmse"] for key in ("unloaded", "curves"))
    assert light != heavy
    assert "motor+fri, unloaded" in capsys.readouterr().out
    assert (tmp_path / "loaded.png").is_file()


def test_the_arm_without_masses_is_that_of_the_other_study(tmp_path: Path) -> None:
    loaded = LoadedStudy(Request(seed=3), tmp_path).every_case()
    light = [case for case in loaded if not case.drive.loaded]
    assert {case.model for case in light} == {"motor+fri", "vrbfs+fri"}
    assert set(light) <= set(SpeedsStudy(Request(seed=3), tmp_path).every_case())
    assert len({case.name for case in loaded}) == len(loaded)
