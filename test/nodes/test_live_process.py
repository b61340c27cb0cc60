"""The workbench's process in the graph: it streams, records, sends, refuses, and ends in time."""

import json
import math
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from node_harness import PATIENCE, Bench, open_bench
from scripted_arm import HZ, TOPIC, Driver, path_of
from sensor_msgs.msg import JointState
from small_model import JOINTS, save_small_model

from lagrangian_ff.arm.trajectory import Trajectory, write_trajectory
from lagrangian_ff.recording import load


class Child:
    """The process, its answers, and the events that it writes."""

    def __init__(self, log: Path) -> None:
        with log.open("w") as errors:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "lagrangian_ff.nodes.live"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
            )
        self.log = log
        self.events: queue.Queue[dict[str, Any]] = queue.Queue()
        self._answers: dict[int, dict[str, Any]] = {}
        self._number = 0
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            event = json.loads(line)
            if "answer" in event:
                self._answers[event["answer"]] = event
            else:
                self.events.put(event)

    def answer(self, bench: Bench, do: str, **asked: Any) -> dict[str, Any]:
        """Return the answer to a command."""
        self._number += 1
        assert self.process.stdin is not None
        print(
            json.dumps({"id": self._number, "do": do, **asked}), file=self.process.stdin, flush=True
        )
        number = self._number
        return dict(bench.until(lambda: self._answers.get(number), f"an answer to {do}"))

    def ask(self, bench: Bench, do: str, **asked: Any) -> dict[str, Any]:
        """Return the answer to a command that is done."""
        answer = self.answer(bench, do, **asked)
        assert "error" not in answer, answer
        return answer

    def refused(self, bench: Bench, do: str, **asked: Any) -> str:
        """Return why a command is refused."""
        return str(self.answer(bench, do, **asked)["error"])

    def until(self, bench: Bench, holds: Callable[[dict[str, Any]], Any], what: str) -> Any:
        """Return the first event from now on for which something holds."""
        while not self.events.empty():
            self.events.get()
        found: list[Any] = []

        def look() -> bool:
            while not self.events.empty() and not found:
                event = self.events.get()
                if holds(event):
                    found.append(event)
            return bool(found)

        bench.until(look, f"{what}; its log: {self.log.read_text()}")
        return found[0]

    def status(self, bench: Bench, holds: Callable[[dict[str, Any]], Any], what: str) -> Any:
        """Return the first status from now on for which something holds."""
        return self.until(bench, lambda event: event["event"] == "status" and holds(event), what)

    def end(self) -> int:
        """Close its standard input, and return the exit code."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        return self.process.wait(PATIENCE)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: Any) -> Path:
    path: Path = tmp_path_factory.mktemp("live")
    save_small_model(path / "model.npz")
    return path


@pytest.fixture
def bench(ros_environment: dict[str, str], folder: Path) -> Iterator[Bench]:
    with open_bench(folder, kills=True) as bench:
        yield bench


@pytest.fixture
def driver(bench: Bench) -> Iterator[Driver]:
    made = Driver(bench.node)
    made.start()
    yield made
    made.end()


@pytest.fixture
def child(bench: Bench, driver: Driver, folder: Path) -> Iterator[Child]:
    made = Child(folder / "live.log")
    yield made
    if made.process.poll() is None:
        made.process.kill()
        made.process.wait()


def motion(path: Path, start: tuple[float, float], joints: tuple[str, ...] = JOINTS) -> str:
    """Write a motion of 3 s that begins and ends at a pose, and return its file."""
    q = np.array([start, np.add(start, 0.5), start])
    still = np.zeros_like(q)
    write_trajectory(path, Trajectory(np.array([0.0, 1.5, 3.0]), q, still, still, joints))
    return str(path)


def test_it_streams_what_the_model_leaves(
    bench: Bench, driver: Driver, child: Child, folder: Path
) -> None:
    raw = child.until(bench, lambda event: event["event"] == "samples", "torque without a model")
    assert raw["joints"] == list(JOINTS)
    assert list(raw["series"]) == ["measured"]
    refused = child.refused(bench, "model", file=str(folder / "nowhere.npz"), effects="")
    assert "no model file" in refused
    child.ask(bench, "model", file=str(folder / "model.npz"), effects="")
    ready = child.status(
        bench, lambda event: all(event["rms"].get(joint) for joint in JOINTS), "the residual"
    )
    assert ready["topic"] == "/joint_states"
    assert ready["publishers"] == 1
    assert ready["joints"] == list(JOINTS)
    assert not ready["warnings"]
    child.status(bench, lambda event: 0.8 * HZ < event["rate"] < 1.2 * HZ, "the rate")
    found = child.until(bench, lambda event: "residual" in event.get("series", {}), "samples")
    torque, rest = (np.array(found["series"][name]["high"]) for name in ("measured", "residual"))
    assert torque.shape == (len(found["time"]), 2)
    predicted = np.array(found["series"]["predicted"]["high"])
    # Where a joint turns round, friction jumps, and the low-pass passes that only in part.
    assert np.median(np.abs(torque - predicted)) < 0.3 < np.abs(torque).max()
    assert np.median(np.abs(rest)) < 0.3
    assert max(ready["rms"].values()) < 0.3


def test_a_model_of_other_joints_is_said(
    bench: Bench, driver: Driver, child: Child, folder: Path
) -> None:
    save_small_model(folder / "other.npz", ("a", "elbow"))
    child.ask(bench, "model", file=str(folder / "other.npz"), effects="")
    words = "without elbow, which the model has"
    child.status(bench, lambda event: any(words in text for text in event["warnings"]), words)


def test_it_records_what_it_hears(bench: Bench, driver: Driver, child: Child, folder: Path) -> None:
    child.status(bench, lambda event: event["joints"], "joint states")
    bag = folder / "recordings" / "one"
    assert "not recording" in child.refused(bench, "finish")
    assert child.ask(bench, "record", path=str(bag))["path"] == str(bag)
    assert "already" in child.refused(bench, "record", path=str(folder / "two"))
    child.status(
        bench, lambda event: (event["recording"] or {}).get("seconds", 0) > 1.0, "a second"
    )
    done = child.ask(bench, "finish")
    recording = load(bag)
    assert done["samples"] == len(recording.time)
    assert recording.joints == JOINTS
    assert np.ptp(recording.time) == pytest.approx(done["seconds"], abs=0.01)


def test_a_motion_is_sent_after_a_slow_way_to_its_start_and_can_be_stopped(
    bench: Bench, driver: Driver, child: Child, folder: Path
) -> None:
    driver.moving, driver.q = False, np.array([0.2, 0.0])
    listed = child.status(bench, lambda event: event["topics"], "the topic of the driver")
    assert listed["topics"] == [{"topic": TOPIC, "nodes": ["/bench"], "subscribers": 1}]
    bench.spin(0.5)
    file = motion(folder / "there.csv", (0.0, 0.0))
    found = child.ask(bench, "prepare", file=file, topic=TOPIC)
    assert found["joints"] == list(JOINTS)
    assert found["nodes"] == ["/bench"]
    np.testing.assert_allclose(found["moved"], [-0.2, 0.0], atol=1e-6)
    assert found["seconds"] == pytest.approx(3.0 + found["way"])
    assert not driver.came
    number = child._number
    assert "prepared last" in child.refused(bench, "send", prepared=number + 7)
    assert "prepared last" in child.refused(bench, "send", prepared=number), "one chance"
    child.ask(bench, "prepare", file=file, topic=TOPIC)
    child.ask(bench, "send", prepared=child._number)
    bench.until(lambda: driver.came, "the motion")
    sent = path_of(driver.came[0])
    np.testing.assert_allclose(sent.q[0], [0.2, 0.0])
    way = np.linspace(0.0, found["way"], 500)
    assert np.abs(sent.sample(way)[1]).max() <= 0.3 + 1e-9
    running = child.status(bench, lambda event: event["motion"], "the motion under way")
    assert running["motion"]["seconds"] == pytest.approx(found["seconds"])
    assert "under way" in child.refused(bench, "prepare", file=file, topic=TOPIC)
    child.status(bench, lambda e: e["motion"]["elapsed"] > found["way"] + 0.5, "the middle")
    child.ask(bench, "stop")
    bench.until(lambda: len(driver.came) >= 2, "the stop")
    rest = path_of(driver.came[1])
    # The path of the motion moves both joints alike: the way to rest does, too.
    np.testing.assert_allclose(rest.q[:, 0], rest.q[:, 1], atol=1e-9)
    assert np.abs(rest.qd[0]).max() > 0.1
    np.testing.assert_allclose(rest.qd[-1], 0.0, atol=1e-9)
    child.status(bench, lambda event: event["motion"] is None, "the rest")
    assert "no motion" in child.refused(bench, "stop")


def test_a_stop_that_the_controller_refuses_is_sent_again(
    bench: Bench, driver: Driver, child: Child, folder: Path
) -> None:
    driver.moving, driver.refusals, driver.q = False, 2, np.zeros(2)
    child.status(bench, lambda event: event["topics"], "the topic of the driver")
    bench.spin(0.5)
    child.ask(bench, "prepare", file=motion(folder / "m.csv", (0.0, 0.0)), topic=TOPIC)
    child.ask(bench, "send", prepared=child._number)
    child.status(bench, lambda e: e["motion"] and e["motion"]["elapsed"] > 1.2, "the motion")
    child.ask(bench, "stop")
    assert len(driver.came) >= 4
    bench.spin(0.7)
    before = driver.q.copy()
    bench.spin(0.3)
    np.testing.assert_allclose(driver.q, before)


def test_the_simulated_arm_takes_the_motion_and_the_stop(bench: Bench, folder: Path) -> None:
    pytest.importorskip("pybullet")
    from lagrangian_ff.arm import HOME
    from lagrangian_ff.arm import JOINTS as SIX

    arm = bench.start("arm")
    child = Child(folder / "beside_the_arm.log")
    home, there = np.array(HOME), np.array(HOME)
    there[[0, 5]] += 1.2
    turn = np.stack([home, there, home])
    still = np.zeros_like(turn)
    path = folder / "turn.csv"
    write_trajectory(path, Trajectory(np.array([0.0, 1.5, 3.0]), turn, still, still, SIX))
    try:
        child.status(bench, lambda event: event["topics"] and event["rate"] > 100.0, "the arm")
        asked = {"file": str(path), "topic": "/arm/joint_trajectory"}
        found = child.ask(bench, "prepare", **asked)
        child.ask(bench, "send", prepared=child._number)
        middle = found["way"] + 0.4
        child.status(bench, lambda e: e["motion"] and e["motion"]["elapsed"] > middle, "the motion")
        child.ask(bench, "stop")
        bench.spin(0.5)
        far = child.ask(bench, "prepare", **asked)["moved"]
        assert 0.2 < -far[0] < 1.25
        assert "refused" not in arm.output
    finally:
        child.process.kill()
        child.process.wait()


def test_what_cannot_be_sent_is_refused_in_words(
    bench: Bench, driver: Driver, child: Child, folder: Path
) -> None:
    child.status(bench, lambda event: event["topics"], "the topic of the driver")
    file = motion(folder / "here.csv", (0.0, 0.0))

    def refused(file: str = file, topic: str = TOPIC) -> str:
        return child.refused(bench, "prepare", file=file, topic=topic)

    assert "moves now" in refused()
    driver.moving = False
    bench.spin(0.5)
    assert "no joint states of c" in refused(motion(folder / "c.csv", (0.0, 0.0), ("a", "c")))
    assert "nobody takes trajectories from /nowhere" in refused(topic="/nowhere")
    assert "nobody takes" in refused(topic="/joint_states")
    assert "no such file" in refused(str(folder / "no.csv"))
    assert "is no topic" in refused(topic="not a topic")
    fast = Trajectory(
        np.array([0.0, 1.0]), np.zeros((2, 2)), np.ones((2, 2)), np.zeros((2, 2)), JOINTS
    )
    write_trajectory(folder / "fast.csv", fast)
    assert "does not begin at rest" in refused(str(folder / "fast.csv"))
    child.ask(bench, "prepare", file=file, topic=TOPIC)
    number = child._number
    driver.q = driver.q + 0.1
    bench.spin(0.5)
    assert "has moved since" in child.refused(bench, "send", prepared=number)
    child.ask(bench, "prepare", file=file, topic=TOPIC)
    number = child._number
    driver.silent = True
    child.status(bench, lambda event: not event["joints"], "the silence")
    assert "stale" in child.refused(bench, "send", prepared=number)
    assert "stale" in refused()
    assert not driver.came


def test_an_arm_that_does_not_follow_is_noticed(
    bench: Bench, driver: Driver, child: Child, folder: Path
) -> None:
    driver.moving, driver.deaf, driver.q = False, True, np.zeros(2)
    child.status(bench, lambda event: event["topics"], "the topic of the driver")
    bench.spin(0.5)
    child.ask(bench, "prepare", file=motion(folder / "m.csv", (0.0, 0.0)), topic=TOPIC)
    child.ask(bench, "send", prepared=child._number)
    child.status(
        bench,
        lambda event: any("does not follow" in text for text in event["warnings"]),
        "a warning",
    )
    child.ask(bench, "stop")
    bench.until(lambda: len(driver.came) >= 2, "the stop")
    np.testing.assert_allclose(path_of(driver.came[1]).q, 0.0)


def test_bad_joint_states_are_warned_of(bench: Bench, driver: Driver, child: Child) -> None:
    driver.silent = True
    publisher = bench.publisher(JointState, "joint_states")
    for effort, words in (([], "without effort"), ([0.0, math.nan], "effort of b is not")):

        def said(event: dict[str, Any], effort: Any = effort, words: str = words) -> bool:
            publisher.publish(JointState(name=list(JOINTS), position=[0.0, 0.0], effort=effort))
            return any(words in text for text in event.get("warnings", []))

        child.until(bench, said, words)


def test_it_ends_with_its_input_closes_the_bag_and_stops_the_motion(
    bench: Bench, driver: Driver, child: Child, folder: Path
) -> None:
    driver.moving, driver.q = False, np.zeros(2)
    child.status(bench, lambda event: event["topics"], "the topic of the driver")
    bench.spin(0.5)
    child.ask(bench, "record", path=str(folder / "last"))
    child.ask(bench, "prepare", file=motion(folder / "m.csv", (0.0, 0.0)), topic=TOPIC)
    child.ask(bench, "send", prepared=child._number)
    child.status(bench, lambda e: e["motion"] and e["motion"]["elapsed"] > 1.0, "the motion")
    began = time.monotonic()
    assert child.end() == 0
    assert time.monotonic() - began < 5.0
    bench.until(lambda: len(driver.came) >= 2, "the stop")
    assert len(load(folder / "last").time) > 0.5 * HZ
    assert "Traceback" not in child.log.read_text()


def test_it_ends_with_a_killed_parent(
    ros_environment: dict[str, str], driver: Driver, bench: Bench
) -> None:
    code = (
        "import subprocess, sys, time\n"
        "made = subprocess.Popen([sys.executable, '-m', 'lagrangian_ff.nodes.live'],"
        " stdin=subprocess.PIPE, stdout=subprocess.PIPE)\n"
        "made.stdout.readline()\n"
        "print(made.pid, flush=True)\n"
        "time.sleep(1000)\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    pid = int(parent.stdout.readline())
    parent.send_signal(signal.SIGKILL)
    parent.wait(PATIENCE)

    def gone() -> bool:
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return True
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        return state == "Z"  # nobody has taken its exit code yet

    bench.until(gone, "its end")
