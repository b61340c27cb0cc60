"""A robot in the graph does what an investigation asks, and stands still after everything else."""

import json
import os
import re
import signal
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("pybullet")

import scripted_arm
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from node_harness import Bench, open_bench
from scripted_arm import Driver, path_of
from std_srvs.srv import Trigger

from lagrangian_ff.arm import HOME, JOINTS, Trajectory
from lagrangian_ff.arm.description import URDF
from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.excite import Limits, Reference, excite
from lagrangian_ff.errors import UserError
from lagrangian_ff.investigation import StoppedError
from lagrangian_ff.nodes.attached.client import Client
from lagrangian_ff.nodes.attached.rig import RosRig, connected
from lagrangian_ff.progress import silent

TOPIC = "/arm/joint_trajectory"
REACH, FASTEST, HARDEST = 0.4, 0.6, 3.0


@pytest.fixture(scope="module")
def bench(ros_environment: dict[str, str], tmp_path_factory: Any) -> Iterator[Bench]:
    with open_bench(tmp_path_factory.mktemp("rig")) as bench:
        bench.start("arm", params={"feedforward_source": "true"})
        yield bench


@pytest.fixture
def rig(bench: Bench, tmp_path: Path) -> Iterator[RosRig]:
    client = Client()
    try:
        client.joints()
        assert client.listeners(TOPIC) == ("/arm",)
        made = RosRig(client, TOPIC, JOINTS, tmp_path / "bags")
        yield made
        made.close()
    finally:
        client.close()


def motion(seconds: float, start: Floats) -> Reference:
    """Return a motion about where the arm stands."""
    every = np.ones(len(JOINTS))
    limits = Limits(start - REACH, start + REACH, FASTEST * every, HARDEST * every)
    return excite("exciting", JOINTS, limits, start=start, duration=seconds)


def speed(rig: RosRig) -> float:
    """Return the fastest joint's speed, rad/s, that is left; it stands if `pose` answers."""
    before = rig.pose()
    time.sleep(0.3)
    return float(np.abs(rig.pose() - before).max() / 0.3)


def after(seconds: float, do: Callable[[], object]) -> threading.Timer:
    """Start a thread that does something soon."""
    timer = threading.Timer(seconds, do)
    timer.start()
    return timer


def test_it_moves_and_records_the_motion(rig: RosRig) -> None:
    start = rig.pose()
    np.testing.assert_allclose(start, HOME, atol=0.5)
    path, shares = motion(5.0, start), []
    found = rig.run(path, None, lambda share, label: shares.append(share))
    assert found.joints == JOINTS
    assert np.ptp(found.time) == pytest.approx(path.time[-1], abs=0.6)
    q = np.array([np.interp(found.time - found.time[0], path.time, one) for one in path.q.T]).T
    assert np.abs(found.position - q).max() < 0.05
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert [bag.exists() for bag in rig.bags] == [True]
    assert not rig.moving


def test_a_stop_from_another_thread_brings_it_to_rest(rig: RosRig) -> None:
    path = motion(12.0, rig.pose())
    timer, began = after(3.0, lambda: rig.stop("enough")), time.monotonic()
    with pytest.raises(StoppedError, match="enough"):
        rig.run(path, None, silent)
    assert time.monotonic() - began < 10.0
    timer.join()
    assert speed(rig) < 0.02
    with pytest.raises(StoppedError, match="enough"):  # nothing moves after a stop
        rig.run(path, None, silent)


def test_a_touch_that_the_monitor_reports_stops_it(rig: RosRig, bench: Bench) -> None:
    publisher = bench.publisher(DiagnosticArray, "/diagnostics")

    def say(name: str, level: bytes) -> None:
        status = DiagnosticStatus(name=name, level=level, message="touched: joint_2")
        publisher.publish(DiagnosticArray(status=[status]))

    harmless = [
        after(2.5, lambda: say("monitor: touch", DiagnosticStatus.OK)),
        after(3.0, lambda: say("identify: touch", DiagnosticStatus.WARN)),
        after(3.5, lambda: say("monitor: residual", DiagnosticStatus.ERROR)),
    ]
    path = motion(5.0, rig.pose())
    rig.run(path, None, silent)
    alarm = after(3.0, lambda: say("left/monitor: touch", DiagnosticStatus.WARN))
    with pytest.raises(StoppedError, match="left/monitor: touched: joint_2"):
        rig.run(path, None, silent)
    for timer in (*harmless, alarm):
        timer.join()
    assert speed(rig) < 0.02
    say("monitor: touch", DiagnosticStatus.WARN)
    with pytest.raises(StoppedError, match="touched"):  # so soon after a touch
        rig.run(path, None, silent)


def test_a_dead_process_is_replaced_to_stop_the_motion(rig: RosRig) -> None:
    path = motion(25.0, rig.pose())
    timer = after(3.0, lambda: os.kill(rig.process, signal.SIGKILL))
    began = time.monotonic()
    with pytest.raises(StoppedError, match="process in the ROS graph has ended"):
        rig.run(path, None, silent)
    timer.join()
    assert time.monotonic() - began < 24.0
    assert speed(rig) < 0.02


@pytest.fixture
def scripted(bench: Bench, tmp_path: Path) -> Iterator[tuple[Driver, RosRig]]:
    """Yield an arm that a script moves, and the rig that moves it."""
    driver = Driver(bench.node)
    driver.moving = False
    driver.start()
    client = Client()
    try:
        client.wait(lambda: "a" in client.status.get("joints", ()) or None, 30.0, "hear a")
        client.listeners(scripted_arm.TOPIC)
        yield driver, RosRig(client, scripted_arm.TOPIC, scripted_arm.JOINTS, tmp_path)
    finally:
        client.close()
        driver.end()


def test_the_joints_are_those_that_the_controller_takes_also_beside_another_arm(
    bench: Bench, tmp_path: Path
) -> None:
    limits = tmp_path / "limits.yaml"
    one = {"min_position": -1.0, "max_position": 1.0, "max_velocity": 1.0}
    limits.write_text(json.dumps({"joint_limits": {"b": one, "gripper": one}}))
    with scripted_arm.driving(0.0, moving=False, takes=["a", "b"]) as driver:
        client = Client()
        with connected(client, scripted_arm.TOPIC, (), None, limits, tmp_path / "bags") as rig:
            assert rig.joints == ("b",)
            assert not driver.came


def test_joint_states_that_end_stop_it_and_a_small_motion_must_be_followed(
    bench: Bench, scripted: tuple[Driver, RosRig]
) -> None:
    driver, rig = scripted
    small = Limits(*(end * np.ones(2) for end in (-0.1, 0.1, 0.4, 2.0)))
    path = excite("exciting", rig.joints, small, start=np.zeros(2), duration=5.0)
    driver.deaf = True
    with pytest.raises(StoppedError, match="a, b did not follow the motion"):
        rig.run(path, None, silent)
    driver.deaf = False
    timer = after(3.0, lambda: setattr(driver, "silent", True))
    with pytest.raises(StoppedError, match="joint states of a, b have ended"):
        rig.run(path, None, silent)
    timer.join()
    bench.until(lambda: np.abs(driver.velocity).max() == 0.0, "the end of the motion")
    assert path_of(driver.came[-1]).duration < 1.0  # a stop, and no other motion


def test_an_arm_that_ignores_stamps_is_followed_and_stopped_without_a_jump(
    scripted: tuple[Driver, RosRig],
) -> None:
    driver, rig = scripted
    driver.hasty = True
    wide = Limits(*(end * np.ones(2) for end in (-1.2, 1.2, 1.5, 6.0)))
    path = excite("exciting", rig.joints, wide, start=np.zeros(2), duration=8.0)
    found = rig.run(path, None, silent)
    expected = Trajectory(*path, rig.joints).sample(found.time - found.time[0])[0]
    assert np.nanmax(np.abs(found.position - expected)) < 0.1
    driver.jump = 0.0
    timer = after(5.0, lambda: rig.stop("enough"))
    with pytest.raises(StoppedError, match="enough"):
        rig.run(path, None, silent)
    timer.join()
    assert len(driver.came) == 3
    assert driver.jump < 0.1
    assert np.abs(driver.velocity).max() == 0.0


def test_a_refused_motion_is_said(rig: RosRig) -> None:
    start = rig.pose()
    path = motion(6.0, start)
    far = Reference(path.time, start + 40.0 * (path.q - start), 40.0 * path.qd, 40.0 * path.qdd)
    with pytest.raises(StoppedError, match="does not follow"):
        rig.run(far, None, silent)
    assert speed(rig) < 0.02


def test_a_topic_that_nobody_listens_to_is_named(rig: RosRig, tmp_path: Path) -> None:
    client = Client()
    try:
        client.joints()
        with pytest.raises(UserError, match=f"nobody takes .* /nowhere; there are: {TOPIC}"):
            client.listeners("/nowhere")
    finally:
        client.close()


def test_the_identify_node_investigates_when_it_is_permitted_and_stops_at_abort(
    bench: Bench, tmp_path: Path
) -> None:
    bench.start(
        "identify",
        params={
            "output_directory": str(tmp_path),
            "investigate.topic": TOPIC,
            "investigate.urdf": str(URDF),
            "investigate.minutes": 0.2,
        },
    )
    answer = bench.call(Trigger, "/identify/investigate")
    assert answer.success, answer.message
    assert "/identify/proceed" in answer.message

    def said() -> str:
        status = bench.statuses.get("identify: investigation")
        return "" if status is None else str(status.message)

    bench.until(lambda: "call /identify/proceed" in said(), "the question")
    assert re.search(r"asks to move for up to 12 s: joint_1 .* to .* rad, up to 1.4 rad/s", said())
    assert not list(tmp_path.rglob("*.csv"))  # nothing moves yet
    assert bench.call(Trigger, "/identify/proceed").success
    bench.until(lambda: "moving" in said(), "the motion")
    assert not bench.call(Trigger, "/identify/proceed").success  # nothing is asked
    bench.spin(2.0)
    assert bench.call(Trigger, "/identify/abort").success
    bench.until(lambda: "/identify/abort was called" in said(), "the end")
    assert Path(bench.values("identify: investigation")["page"]).is_file()
    assert (tmp_path / "investigation" / "motion_01.csv").is_file()
