"""Ten thousand random messages at each node with RANDOM_MESSAGES=10000; some hundreds without."""

import os
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("pybullet")

from fault_world import LIMIT, World
from node_harness import LATCHED, RELIABLE, Bench, Process, heard, open_bench
from random_messages import RandomMessages
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from small_model import motion_at, save_small_model, torque_of
from std_msgs.msg import Float64MultiArray, String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

COUNT = int(os.environ.get("RANDOM_MESSAGES", "400"))
RATE = 1000.0  # Hz, about as fast as all nodes read


@pytest.fixture
def bench(ros_environment: dict[str, str], tmp_path: Path) -> Iterator[Bench]:
    with open_bench(tmp_path) as bench:
        yield bench


def rain(bench: Bench, process: Process, topics: Mapping[str, type], seed: int) -> None:
    """Publish random messages on these topics in turn; the node must stay alive."""
    made = RandomMessages(seed, bench.node.get_clock().now().nanoseconds)
    profile = {String: LATCHED}
    publishers = [
        (bench.node.create_publisher(kind, topic, profile.get(kind, RELIABLE)), kind)
        for topic, kind in topics.items()
    ]
    bench.until(
        lambda: all(publisher.get_subscription_count() for publisher, _ in publishers),
        f"subscribers of {', '.join(topics)}",
    )
    for k in range(COUNT):
        publisher, kind = publishers[k % len(publishers)]
        # A robot describes itself once; one in a hundred messages is more than that.
        if kind is not String or k % 100 < len(publishers):
            publisher.publish(made.of(kind))
        time.sleep(1.0 / RATE)
        if k % 20 == 0:
            bench.spin(0.005)
    for publisher, _ in publishers:
        bench.node.destroy_publisher(publisher)
    assert process.alive, process.output
    for word in ("Traceback", "RuntimeWarning"):
        assert word not in process.output, process.output


def test_torques_stay_finite_and_within_their_limits(bench: Bench, tmp_path: Path) -> None:
    world = World(bench, tmp_path, [])
    try:
        world.usual()
        topics = {"feedforward/reference": JointTrajectory, "joint_states": JointState}
        rain(bench, world.main, {**topics, "robot_description": String}, seed=1)
        world.usual()
        torques = world.all_torques()
        assert len(torques) > COUNT / RATE * 100.0
        assert np.isfinite(torques).all()
        assert np.abs(torques).max() <= LIMIT + 1e-9
        assert world.sizes == {2.0}
    finally:
        world.close()


def test_a_simulated_clock_gone_mad_moves_no_torque_too_far(bench: Bench, tmp_path: Path) -> None:
    save_small_model(tmp_path / "model.npz")
    limits = {f"limits.{joint}.effort": LIMIT for joint in "ab"}
    params = {"model_file": str(tmp_path / "model.npz"), "use_sim_time": True, **limits}
    process = bench.start("feedforward", params=params)
    commands = bench.collect(Float64MultiArray, "feedforward/commands")
    topics = {"clock": Clock, "joint_states": JointState, "feedforward/reference": JointTrajectory}
    rain(bench, process, topics, seed=2)
    assert all(np.abs(message.data).max(initial=0.0) <= LIMIT + 1e-9 for _, message in commands)
    assert bench.parameters("feedforward")


def test_the_watchdog_passes_on_nothing_that_is_no_torque(bench: Bench) -> None:
    limits = {f"limits.{joint}.effort": LIMIT for joint in "ab"}
    process = bench.start("watchdog", params={"joints": ["a", "b"], **limits})
    commands = bench.collect(Float64MultiArray, "watchdog/commands")
    rain(bench, process, {"feedforward/commands": Float64MultiArray}, seed=3)
    publisher = bench.publisher(Float64MultiArray, "feedforward/commands")

    def passed() -> bool:
        publisher.publish(Float64MultiArray(data=[1.0, 2.0]))
        return bool(commands) and list(commands[-1][1].data) == [1.0, 2.0]

    bench.until(passed, "what comes to be passed on")
    for _, message in commands:
        assert len(message.data) == 2
        assert np.abs(message.data).max() <= LIMIT + 1e-9


def test_the_monitor_goes_on(bench: Bench, tmp_path: Path) -> None:
    save_small_model(tmp_path / "model.npz")
    params = {"model_file": str(tmp_path / "model.npz"), **heard("/joint_states")}
    process = bench.start("monitor", params=params)
    residual = bench.collect(JointState, "monitor/residual")
    rain(bench, process, {"joint_states": JointState}, seed=4)
    assert all(np.isfinite(message.effort).all() for _, message in residual)
    residual.clear()
    publisher = bench.publisher(JointState, "joint_states")

    def judged() -> bool:
        now = bench.node.get_clock().now()
        q, qd, qdd = motion_at(np.array([now.nanoseconds % 10**12 / 1e9]))
        message = JointState(name=["a", "b"], position=q[0].tolist())
        message.effort = torque_of(q, qd, qdd)[0].tolist()
        message.header.stamp = now.to_msg()
        publisher.publish(message)
        bench.spin(0.01)
        return bool(residual)

    bench.until(judged, "residuals of sound joint states")


def test_a_recording_of_anything_is_kept_and_said(bench: Bench, tmp_path: Path) -> None:
    params = {"output_directory": str(tmp_path / "bags"), **heard("/joint_states")}
    process = bench.start("identify", params=params)
    assert bench.call(Trigger, "identify/start").success
    rain(bench, process, {"joint_states": JointState, "robot_description": String}, seed=5)
    stopped = bench.call(Trigger, "identify/stop")
    assert "Traceback" not in stopped.message + process.output
    answer = bench.call(Trigger, "identify/identify")
    assert answer.message
    assert process.alive, process.output


def test_the_simulated_arm_goes_on(bench: Bench) -> None:
    process = bench.start("arm")
    states = bench.collect(JointState, "joint_states")
    topics: dict[str, Any] = {"arm/joint_trajectory": JointTrajectory}
    rain(bench, process, {**topics, "arm/commands": Float64MultiArray}, seed=6)
    for _, message in states:
        assert np.isfinite(np.r_[message.position, message.velocity, message.effort]).all()
    states.clear()
    bench.until(lambda: len(states) > 100, "joint states")
