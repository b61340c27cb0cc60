"""The feedforward node under simulated time: in step with the joint states."""

import math
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from builtin_interfaces.msg import Duration
from node_harness import RELIABLE, Bench, heard, open_bench
from sensor_msgs.msg import JointState
from small_model import save_small_model
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

PERIOD = 2_000_000


@pytest.fixture
def bench(ros_environment: dict[str, str], tmp_path: Path) -> Iterator[Bench]:
    save_small_model(tmp_path / "model.npz")
    with open_bench(tmp_path) as bench:
        yield bench


def standing(q: float) -> JointTrajectory:
    message = JointTrajectory(joint_names=["a", "b"])
    for at in (0, 100_000_000):
        point = JointTrajectoryPoint(positions=[q, q])
        point.time_from_start = Duration(nanosec=at)
        message.points.append(point)
    return message


def test_under_simulated_time_each_joint_state_is_answered_once(
    bench: Bench, tmp_path: Path
) -> None:
    # Whoever publishes no /clock still stamps joint states, and time stands while none come.
    states = bench.node.create_publisher(JointState, "/simulated/joint_states", RELIABLE)
    process = bench.start(
        "feedforward",
        namespace="simulated",
        params={
            "model_file": str(tmp_path / "model.npz"),
            "use_sim_time": True,
            "ramp_time": 0.1,
            "start_delay": 0.2,
            **heard("/simulated/joint_states"),
        },
    )
    commands = bench.collect(Float64MultiArray, "/simulated/feedforward/commands")
    stamped = bench.collect(JointState, "/simulated/feedforward/feedforward")
    send = bench.publisher(JointTrajectory, "/simulated/feedforward/reference")
    bench.until(lambda: states.get_subscription_count() > 0, "a reader of joint states")
    status = "simulated/feedforward: stream"
    bench.until(
        lambda: status in bench.statuses and "/clock" in bench.statuses[status].message, "a word"
    )
    now = 5 * 10**9

    def tick() -> None:
        nonlocal now
        now += PERIOD
        message = JointState(name=["a", "b"], position=[0.4, 0.4])
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(now, 10**9)
        states.publish(message)
        before = len(commands)
        bench.until(lambda: len(commands) > before, "the answer")

    tick()
    send.publish(standing(0.4))

    def planned() -> bool:
        tick()
        return "feedforward for 2 points" in process.output

    bench.until(planned, "the plan")
    bench.until_quiet(commands, "commands while time stands")
    commands.clear()
    for _ in range(250):
        tick()
    bench.until_quiet(commands, "answers")
    assert len(commands) == 250
    assert commands[-1][1].data[0] == pytest.approx(8.0 * math.cos(0.4), rel=0.002)
    at = stamped[-1][1].header.stamp
    assert divmod(now, 10**9) == (at.sec, at.nanosec)
    assert process.alive
