"""The whole demo with short motions: real processes, real DDS, and a better tracking arm."""

import json
import os
import re
import subprocess
import sys
import time
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from lagrangian_ff.numbers import mrad, percent
from lagrangian_ff.report import html

pytest.importorskip("rclpy", reason="rclpy is not installed")

JOINTS = [f"joint_{n}" for n in range(1, 7)]
RUN = (
    "import sys; from pathlib import Path; from lagrangian_ff.demo import QUICK, Options, run\n"
    "sys.exit(run(Options(Path(sys.argv[1]), domain=int(sys.argv[2]), **QUICK)))"
)
PATIENCE = 400.0  # s, several times what it takes on a machine of its own


def start(output: Path, environment: dict[str, str], log: Path) -> "subprocess.Popen[bytes]":
    """A quick demo in a process of its own."""
    arguments = [str(output), environment["ROS_DOMAIN_ID"]]
    with log.open("wb") as file:
        return subprocess.Popen(
            [sys.executable, "-c", RUN, *arguments],
            env=environment,
            stdout=file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )


@pytest.fixture(scope="module")
def demo(
    ros_environment: dict[str, str], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, str]:
    """The folder that a quick demo leaves, and what it printed."""
    folder = tmp_path_factory.mktemp("demo")
    log = folder / "printed.txt"
    process = start(folder / "out", ros_environment, log)
    try:
        code = process.wait(PATIENCE)
    finally:
        process.kill()
    printed = log.read_text(encoding="utf-8")
    assert code == 0, printed
    assert not leftovers(ros_environment), printed
    return folder / "out", printed


def leftovers(environment: dict[str, str]) -> list[str]:
    """Node processes in this domain that still run."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            command = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode()
            surroundings = (entry / "environ").read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        here = f"ROS_DOMAIN_ID={environment['ROS_DOMAIN_ID']}" in surroundings
        if here and "lagrangian_ff.nodes." in command:
            found.append(command)
    return found


@pytest.fixture(scope="module")
def record(demo: tuple[Path, str]) -> dict[str, Any]:
    """The numbers it left."""
    found: dict[str, Any] = json.loads((demo[0] / "demo.json").read_text(encoding="utf-8"))
    return found


@pytest.mark.parametrize("motion", ["training", "unseen"])
def test_each_part_of_the_feedforward_improves_tracking(
    record: dict[str, Any], motion: str
) -> None:
    found = record["tracking"][motion]
    none, without, full, bound = (
        found["runs"][run]["rms"] for run in ("none", "without_friction", "all", "bound")
    )
    assert none > without > full > bound > 0.0
    assert full <= none / 2.0
    assert found["ratio"] == pytest.approx(full / none)
    assert found["ordered"] is True


def test_every_joint_is_told_of(record: dict[str, Any]) -> None:
    assert list(record["torque"]["joints"]) == JOINTS
    for motion in record["tracking"].values():
        for run in motion["runs"].values():
            assert list(run["joints"]) == JOINTS


def test_the_torque_is_judged_on_the_motion_it_never_saw(record: dict[str, Any]) -> None:
    seconds = record["options"]["unseen_duration"]
    assert record["torque"]["samples"] == pytest.approx(500 * seconds, rel=0.2)
    for errors in record["torque"]["joints"].values():
        assert 0.0 < errors["nmse"] < 1.0


def test_no_process_holds_much_memory(record: dict[str, Any]) -> None:
    memory = record["memory"]
    assert {"arm", "feedforward", "identify", "conductor", "largest child"} <= set(memory)
    assert max(memory.values()) < 1.5e9


def test_the_page_shows_the_numbers_of_the_record(
    demo: tuple[Path, str], record: dict[str, Any]
) -> None:
    page = (demo[0] / "index.html").read_text(encoding="utf-8")
    without_style = re.sub(r"<style>.*?</style>", "", page, flags=re.DOTALL)
    shown = {unescape(text).strip() for text in re.split(r"<[^>]*>", without_style)}
    for found in record["tracking"].values():
        assert percent(found["ratio"]) in shown
        for run in found["runs"].values():
            assert mrad(run["rms"]) in shown
            assert {mrad(errors["rms"]) for errors in run["joints"].values()} <= shown
    assert not re.search(r"://", re.sub(r'base64,[^"]*', "", page))


def test_it_leaves_pictures_model_and_recordings(demo: tuple[Path, str]) -> None:
    from lagrangian_ff.identification import Model
    from lagrangian_ff.recording import load

    folder = demo[0]
    for name in ("arm", "torque", "tracking_bars", "tracking_training", "tracking_unseen"):
        assert (folder / f"{name}.png").read_bytes().startswith(html.PNG)
    assert list(Model.load(folder / "model.npz").joints) == JOINTS
    bags = [path for path in (folder / "recording").iterdir() if path.is_dir()]
    assert len(bags) == 1
    for bag in (*bags, folder / "unseen_motion"):
        assert list(load(bag).joints) == JOINTS


def test_it_prints_the_errors_and_the_verdict(
    demo: tuple[Path, str], record: dict[str, Any]
) -> None:
    printed = demo[1]
    for word in (*JOINTS, "no feedforward", "without friction", "with friction", "bound"):
        assert word in printed
    for found in record["tracking"].values():
        assert percent(found["ratio"]) in printed
        assert mrad(found["runs"]["all"]["rms"]) in printed
    assert "Traceback" not in printed


def test_ctrl_c_ends_every_node(ros_environment: dict[str, str], tmp_path: Path) -> None:
    log = tmp_path / "printed.txt"
    process = start(tmp_path / "out", ros_environment, log)
    try:
        end = time.monotonic() + PATIENCE
        while "is recorded" not in log.read_text(encoding="utf-8"):
            assert process.poll() is None, log.read_text(encoding="utf-8")
            assert time.monotonic() < end, "the recording never began"
            time.sleep(0.1)
        assert len(leftovers(ros_environment)) == 2
        os.kill(process.pid, 2)
        process.wait(PATIENCE)
    finally:
        process.kill()
    assert not leftovers(ros_environment)
