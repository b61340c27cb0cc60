"""`study speeds` and `study loaded`: small ones to the findings, and what they refuse."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lagrangian_ff.arm import true_torque
from lagrangian_ff.arm.description import LOAD_POINTS
from lagrangian_ff.cli.main import main
from lagrangian_ff.studies.arm import LOADS, Drive
from lagrangian_ff.studies.speeds import MODELS, LoadedStudy, SpeedsStudy
from lagrangian_ff.studies.study import Request

QUICK = ["study", "speeds", "--quick", "--jobs", "1", "--output"]


def done(folder: Path) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    lines = (folder / "cases.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines], json.loads((folder / "summary.json").read_text())


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("speeds")
    assert main([*QUICK, str(folder), "--cases", "speed0[59]-*", "--keep"]) == 0
    return folder


def given(recordings: Path, folder: Path, speed: int = 5) -> None:
    """Give a study one of the recordings of another, as if it were of speed 5."""
    (folder / "recordings").mkdir()
    shutil.copy(recordings / f"speed{speed:02d}.npz", folder / "recordings" / "speed05.npz")


def test_its_findings_hold(small: Path) -> None:
    lines, numbers = done(small)
    assert [line["case"] for line in lines] == [
        f"speed{speed:02d}-{model}"
        for model in ("motor+fri", "vrbfs+fri", "auto+fri")
        for speed in (5, 9)
    ]
    findings = numbers["findings"]
    assert findings["lagrangian_best"]["holds"]
    assert findings["auto+fri_better"]["holds"]
    assert findings["auto+fri_better"]["below"] == 2
    slow, fast = numbers["curves"]["auto+fri"]["velocity"]
    assert fast > 1.3 * slow
    assert (small / "speeds.png").read_bytes().startswith(b"\x89PNG")


def test_a_line_has_the_error_by_joint_and_what_was_chosen(small: Path) -> None:
    for line in done(small)[0]:
        error = np.array([joint["rmse"] for joint in line["joints"].values()])
        torque = error / [joint["relative"] for joint in line["joints"].values()]
        assert line["rmse"] == pytest.approx(np.sqrt(np.mean(error**2)))
        assert line["relative"] == pytest.approx(line["rmse"] / np.sqrt(np.mean(torque**2)))
        # The torque is that of the last two thirds, which no model has a share in.
        motion = Drive(line["speed"], 0, 9.0, kept=small / "recordings").motion()
        later = motion.tau[round(len(motion) / 3) :]
        np.testing.assert_allclose(torque, np.sqrt(np.mean(later**2, axis=0)), rtol=0.01)
        assert line["chosen"]["hyperparameters"]
    assert line["chosen"]["model"] in ("chain+fri", "chain_rbf+fri")


def test_friction_beside_the_kernel_is_needed(
    small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given(small / "recordings", tmp_path)
    models = ["--models", "vrbfs", "vrbfs+fri", "rbfs", "rbfs+fri"]
    assert main([*QUICK, str(tmp_path), "--cases", "speed05-*", "--keep", *models]) == 0
    needed = done(tmp_path)[1]["findings"]["friction_needed"]
    assert needed["holds"]
    assert set(needed["ratio"]) == {"vrbfs", "rbfs"}
    out = capsys.readouterr().out
    assert "yes  friction beside the kernel is needed" in out
    assert out.count("\n  rbfs") == 2


def test_kept_recordings_are_used(small: Path, tmp_path: Path) -> None:
    kept = {file.name for file in (small / "recordings").iterdir()}
    assert kept == {"speed05.npz", "speed09.npz"}
    given(small / "recordings", tmp_path, speed=9)
    options = ["--cases", "speed05-*", "--models", "motor+fri", "--keep"]
    assert main([*QUICK, str(tmp_path), *options]) == 0
    (again,) = done(tmp_path)[0]
    before = next(line for line in done(small)[0] if line["case"] == "speed09-motor+fri")
    names = {"case": "", "speed": 0, "seconds": 0}
    assert {**again, **names} == {**before, **names}


def test_the_whole_study_has_every_model_at_every_speed(tmp_path: Path) -> None:
    names = {case.name for case in SpeedsStudy(Request(), tmp_path).every_case()}
    assert len(names) == 10 * len(MODELS)
    kernels = ("rbf", "rbfs", "srbf", "srbfs", "vrbf", "vrbfs", "pol")
    papers = [f"{kernel}{end}" for kernel in kernels for end in ("", "+fri")]
    assert {f"speed10-{model}" for model in [*papers, "motor+fri", "auto+fri"]} <= names


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--models", "nonsense"], "'nonsense' is neither a kernel"),
        (["--robots", "3"], "study speeds has no --robots"),
        (["--cases", "speed11-*"], "no case is named 'speed11-*'"),
    ],
)
def test_mistakes_are_reported_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], message: str
) -> None:
    assert main([*QUICK, str(tmp_path / "study"), *options]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not (tmp_path / "study").exists()


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
