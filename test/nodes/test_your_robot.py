"""docs/your_robot.md, walked: what its blocks say is done, on an arm behind the rules of JTC.

The lines of `ros2` are done by what they stand for: a process for `launch`, a call for `service`.
"""

import json
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("pybullet")

from action_msgs.msg import GoalStatus
from built_interfaces import follow_joint_trajectory
from feedforward_bench import planned, tracked
from node_harness import LATCHED, Bench, heard, open_bench
from rclpy.action import ActionClient
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff.arm import JOINTS, Trajectory, exciting_trajectory
from lagrangian_ff.cli.main import main

DOCUMENT = Path(__file__).parents[2] / "docs" / "your_robot.md"
PROFILE = "gz_ros2_control"
HIDDEN = "quadratic_drag@joint_2:0.2"
FIRST, OTHER = (0, 30.0), (1, 10.0)  # seed and s of a motion
JOBS = {"identify": "identification", "compare": "comparison", "diagnose": "diagnosis",
        "add": "addition"}  # fmt: skip
PATIENCE = 120.0  # s


def steps() -> dict[int, list[str]]:
    """Return the lines of the blocks of each step."""
    found: dict[int, list[str]] = {}
    for section in DOCUMENT.read_text(encoding="utf-8").split("\n## ")[1:]:
        blocks = re.findall(r"^```bash\n(.*?)^```", section, re.MULTILINE | re.DOTALL)
        found[int(section.split(".")[0])] = [line for b in blocks for line in b.splitlines()]
    return found


class Walk:
    """A robot that is not moved by torque yet, and what was seen on the way."""

    def __init__(self, bench: Bench, action: Any, folder: Path, interfaces: list[str]) -> None:
        self.first = FIRST
        self.bench, self.action, self.folder = bench, action, folder
        self.robot = bench.start(
            "stand_in_controller",
            params={"command_interfaces": interfaces, "offered": interfaces, "speed": 1.0,
                    "hidden": [HIDDEN]},
        )  # fmt: skip
        self.states = bench.collect(JointState, "/joint_states")
        bench.until(lambda: self.states, "joint states")
        self.reports: list[dict[str, Any]] = []
        bench.node.create_subscription(String, "/identify/report", self._on_report, LATCHED)
        self.errors: list[float] = []
        self.recorder: Any = None

    def _on_report(self, message: Any) -> None:
        self.reports.append(json.loads(message.data))

    def go(self, lines: list[str]) -> None:
        """Do the lines of a step."""
        for line in lines:
            self._do(line.strip())

    def _do(self, line: str) -> None:
        if line.startswith("# move the robot by the feedforward"):
            self._move("feedforward", 3, 6.0)
            self.errors.append(tracked(self.robot))
        elif line.startswith("# move the robot"):
            motion = OTHER if line.endswith("otherwise") else self.first
            self._move("joint_trajectory_controller", *motion)
        elif line.startswith("ros2 param set") and line.endswith("# for each joint"):
            for joint in JOINTS:
                self._do(line.partition("#")[0].replace("JOINT", joint).strip())
        else:
            text = line.replace("~/recordings", str(self.folder)).replace("PROFILE", PROFILE)
            words = shlex.split(text, comments=True)
            kind = "_".join(words[:2]) if words[0] == "ros2" else words[0]
            getattr(self, f"_{kind}")(words)

    def _lagrangian_ff(self, words: list[str]) -> None:
        assert main(words[1:]) == 0

    def _ros2_topic(self, words: list[str]) -> None:
        if "hz" in words:
            before = len(self.states)
            self.bench.spin(2.0)
            assert len(self.states) - before > 150
        elif words[-1] == "/joint_states":
            assert len(self.states[-1][1].effort) == len(JOINTS)
        elif words[-1] == "/identify/report":
            self.bench.until(lambda: self.reports, "a report")
        else:
            name = re.findall(r"one.name == '(.*?)'", words[-1])[0]
            assert self.bench.values(name), name

    def _ros2_launch(self, words: list[str]) -> None:
        file = DOCUMENT.parents[1] / "launch" / words[3]
        given = dict(word.split(":=") for word in words[4:])
        assert all(f'"{name}"' in file.read_text() + LAUNCHING for name in given), given
        name = words[3].split(".")[0]
        executable = {"record": "identify"}.get(name, name)
        reliable = heard("/joint_states")
        process = self.bench.start(executable, params={**given, **reliable})
        if executable == "identify":
            self.recorder = process
            self.bench.until(
                lambda: self.bench.values("identify: input").get("joints"), "joint states"
            )
        elif executable == "monitor":
            self.bench.until(lambda: self.bench.values("monitor: input"), "the monitor")
        else:
            status = "feedforward: controller"
            self.bench.until(lambda: "effort" in self.said(status), "the controller", PATIENCE)

    def said(self, status: str) -> str:
        """Return the message of a status."""
        found = self.bench.statuses.get(status)
        return "" if found is None else str(found.message)

    def _ros2_param(self, words: list[str]) -> None:
        assert self.bench.set_parameter(words[3], words[4], float(words[5])).successful

    def _ros2_service(self, words: list[str]) -> None:
        node, service = words[3].strip("/").split("/")
        if service == "enable":
            assert self.bench.call(SetBool, f"{node}/{service}").success
            return
        answer = self.bench.call(Trigger, f"{node}/{service}")
        assert answer.success, answer.message
        if service in JOBS:
            status = f"identify: {JOBS[service]}"
            self.bench.until(
                lambda: self.bench.values("identify: input").get("state") == "idle"
                and "progress" not in self.bench.values(status)
                and self.bench.values(status),
                service, PATIENCE,
            )  # fmt: skip
            assert f"~/{service} failed" not in self.recorder.output, self.recorder.output

    def _move(self, server: str, seed: int, duration: float) -> None:
        """Go to the start of a motion, and along it."""
        motion = exciting_trajectory(4, seed=seed, duration=duration)
        q, still = motion.q[[0, 0]], np.zeros((2, len(JOINTS)))
        q[0] = np.array(self.states[-1][1].position)
        self._follow(
            server, planned(Trajectory(np.array([0.0, 2.0]), q, still, still), 3.0, JOINTS)
        )
        self._follow(server, planned(motion, 0.1, JOINTS))

    def _follow(self, server: str, trajectory: JointTrajectory) -> None:
        client = ActionClient(self.bench.node, self.action, f"/{server}/follow_joint_trajectory")
        self.bench.until(client.server_is_ready, server)
        sent = client.send_goal_async(self.action.Goal(trajectory=trajectory))
        self.bench.until(sent.done, "the answer to a goal")
        assert sent.result().accepted
        ended = sent.result().get_result_async()
        self.bench.until(ended.done, "the end of a goal", PATIENCE)
        assert ended.result().status == GoalStatus.STATUS_SUCCEEDED
        client.destroy()


LAUNCHING = (DOCUMENT.parents[1] / "lagrangian_ff" / "nodes" / "launching.py").read_text()


@pytest.fixture
def action(ros_environment: dict[str, str]) -> Iterator[Any]:
    """Yield the type of the action, for this process and for those that it starts."""
    with follow_joint_trajectory() as kind:
        yield kind


@pytest.fixture
def bench(action: Any, tmp_path: Path) -> Iterator[Bench]:
    with open_bench(tmp_path) as bench:
        yield bench


def test_the_way_of_an_arm_that_takes_torque(bench: Bench, action: Any, tmp_path: Path) -> None:
    walk, way = Walk(bench, action, tmp_path, ["effort"]), steps()
    assert sorted(way) == list(range(1, 10))
    for number in range(1, 7):
        walk.go(way[number])
    said = walk.said("identify: diagnosis")
    assert "missing: quadratic drag on joint_2" in said, said
    assert (tmp_path / "model.npz").is_file()
    walk.first = OTHER
    walk.go(way[7])
    assert walk.said("monitor: residual")
    assert (tmp_path / "torque.xml").is_file()
    walk.go(way[8])
    assert "effort is filled" in walk.said("feedforward: controller")
    walk.go(way[9])
    print("\ntracking, rms mrad:", ", ".join(f"{error:.2f}" for error in walk.errors))
    fifth, half, whole = walk.errors
    assert whole < 0.7 * half < 0.7 * fifth


def test_the_way_of_an_arm_that_takes_positions_alone(
    bench: Bench, action: Any, tmp_path: Path
) -> None:
    walk, way = Walk(bench, action, tmp_path, ["position"]), steps()
    walk.first = OTHER
    # Steps 5 and 6 are the same calls as on the other way.
    for number in (1, 2, 3, 4):
        walk.go(way[number])
    assert bench.call(Trigger, "identify/save").success
    walk.go(way[7])
    assert walk.said("monitor: residual")
    walk.go(way[8])
    said = walk.said("feedforward: controller")
    assert "position" in said, said
    assert bench.values("feedforward: controller")["goals"] == "2", "they pass as they are"
