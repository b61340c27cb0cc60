"""The command `investigate`: on the simulated arm, and what it refuses before anything moves."""

import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from lagrangian_ff.cli.main import main
from lagrangian_ff.identification import Model

TOPIC = "/arm/joint_trajectory"
LIMITS = """
joint_limits:
  a: {min_position: -1.0, max_position: 1.0, max_velocity: 2.0}
"""


def test_the_simulated_arm_is_investigated(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("pybullet")
    files = {name: tmp_path / name for name in ("m.npz", "s.html", "s.json")}
    assert main([
        "investigate", "--simulate", "asymmetric_viscous@joint_2:0.2", "--minutes", "0.2",
        "--output", str(files["m.npz"]), "--report", str(files["s.html"]),
        "--json", str(files["s.json"]),
    ]) == 0  # fmt: skip
    said = capsys.readouterr().out
    assert "the simulated arm: to move for up to 12 s" in said
    assert "moving for 12 s: What does the arm do?" in said
    assert "the time for motion is used" in said
    story: dict[str, Any] = json.loads(files["s.json"].read_text())
    assert story["seconds"] <= 12.0
    (turn,) = story["turns"]
    assert turn["rmse"] <= 1.5 * story["before"]["rmse"]
    assert Model.load(files["m.npz"]).joints == tuple(story["joints"])
    assert "</html>" in files["s.html"].read_text()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ([], "--topic"),
        (["--topic", TOPIC], "--urdf or --limits"),
        (["--topic", TOPIC, "--limits", "FILE", "--yes", "/other"], "the very name of the topic"),
        (["--simulate", "nothing", "--topic", TOPIC], "--topic is for a robot"),
        (["--simulate", "stribeck@joint_9:0.1"], "stribeck can be on"),
        (["--simulate", "nothing", "--minutes", "0"], "--minutes 0"),
        (["--topic", TOPIC, "--limits", "FILE", "--floor", "0"], "need --urdf"),
        (["--topic", TOPIC, "--limits", "FILE", "--output", "m.csv"], "ends in .npz"),
        (["--topic", TOPIC, "--limits", "FILE", "--folder", "HERE"], "is not empty"),
    ],
)
def test_mistakes_are_said_before_anything_moves(
    given: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "limits.yaml"
    file.write_text(LIMITS)
    places = {"FILE": str(file), "HERE": str(tmp_path)}
    arguments = [places.get(one, one) for one in given]
    assert main(["investigate", *arguments]) == 2
    assert words in capsys.readouterr().err


def test_ctrl_c_keeps_what_is_known(tmp_path: Path) -> None:
    """Before the first motion is done nothing is: the story says so, and the page is there."""
    pytest.importorskip("pybullet")
    page = tmp_path / "s.html"
    command = [sys.executable, "-m", "lagrangian_ff.cli", "investigate", "--simulate", "nothing"]
    process = subprocess.Popen([*command, "--report", str(page)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    for line in process.stdout:
        if "moving for" in line:
            process.send_signal(signal.SIGINT)
            break
    rest = process.stdout.read()
    assert process.wait(60.0) == 130
    assert "stopped by the user (SIGINT)" in rest
    assert "</html>" in page.read_text()
