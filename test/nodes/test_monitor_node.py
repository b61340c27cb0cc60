"""The monitor over DDS: what the model explains, what it does not, and what is no joint state."""

import math
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from node_harness import Bench, Process, configured, heard, open_bench
from sensor_msgs.msg import JointState
from small_model import JOINTS, motion_at, save_small_model, torque_of

from lagrangian_ff.nodes.common.topics import nanoseconds, stamp

START = 1_700_000_000_000_000_000  # ns


@pytest.fixture(scope="module")
def folder(tmp_path_factory: Any) -> Path:
    path: Path = tmp_path_factory.mktemp("monitor")
    save_small_model(path / "model.npz")
    return path


@pytest.fixture(scope="module")
def bench(ros_environment: dict[str, str], folder: Path) -> Iterator[Bench]:
    with open_bench(folder) as bench:
        yield bench


@pytest.fixture(scope="module")
def monitor(bench: Bench, folder: Path) -> Process:
    # The model's own error is that of a motion without noise: a thousandth of its torque.
    names = {"model_file": str(folder / "model.npz"), "warn_ratio": 20.0, "error_ratio": 50.0}
    return bench.start("monitor", params={**names, **heard("/joint_states")})


def send(bench: Bench, publisher: Any, begin: float, seconds: float, drag: float = 0.0) -> None:
    """Publish the small model's motion, faster than it is; joint c is none of the model's."""
    time = np.arange(begin, begin + seconds, 0.004)
    q, qd, qdd = motion_at(time)
    tau = torque_of(q, qd, qdd)
    tau[:, 1] += drag * qd[:, 1] * np.abs(qd[:, 1])
    for k, t in enumerate(time):
        message = JointState(
            name=["c", *reversed(JOINTS)],
            position=[0.0, q[k, 1], q[k, 0]],
            effort=[0.0, tau[k, 1], tau[k, 0]],
        )
        message.header.stamp = stamp(START + round(t * 1e9))
        publisher.publish(message)
        if k % 25 == 0:
            bench.spin(0.01)


def message_of(bench: Bench) -> str:
    return str(getattr(bench.statuses.get("monitor: residual"), "message", ""))


def test_every_parameter_of_the_installed_file_is_declared(bench: Bench, monitor: Process) -> None:
    assert configured("monitor") <= bench.parameters("monitor")
    result = bench.set_parameter("monitor", "model_file", "other.npz")
    assert not result.successful


def test_what_the_model_explains_leaves_nothing(bench: Bench, monitor: Process) -> None:
    residual = bench.collect(JointState, "monitor/residual")
    predicted = bench.collect(JointState, "monitor/predicted")
    publisher = bench.publisher(JointState, "joint_states")
    bench.until(lambda: bench.node.count_publishers("monitor/residual"), "its topics")
    send(bench, publisher, 0.0, 8.0)
    share = bench.until(
        lambda: bench.values("monitor: residual").get("outside the 90 % interval a"), "a share"
    )
    assert 0.0 <= float(share.rstrip("%")) <= 100.0
    assert "as when identified" in message_of(bench)
    left = np.stack([message.effort for _, message in residual])
    torque = np.stack([message.effort for _, message in predicted])
    assert residual[0][1].name == list(JOINTS)
    assert np.sqrt(np.mean(left**2)) < 0.05 * np.std(torque)
    at = np.array([(nanoseconds(m.header.stamp) - START) / 1e9 for _, m in predicted])
    q, qd, _ = motion_at(at)
    np.testing.assert_allclose(np.stack([m.position for _, m in predicted]), q, atol=2e-3)
    np.testing.assert_allclose(np.stack([m.velocity for _, m in predicted]), qd, atol=2e-2)
    assert float(bench.values("monitor: input")["delay [s]"]) == pytest.approx(0.02546, abs=1e-4)


def test_bad_messages_are_counted_and_new_physics_is_noticed(
    bench: Bench, monitor: Process
) -> None:
    publisher = bench.publisher(JointState, "joint_states")
    for _ in range(20):
        publisher.publish(JointState(name=["a"], position=[0.0], effort=[0.0]))
        publisher.publish(JointState(name=["a", "b"], position=[math.nan, 0.0], effort=[0.0, 0.0]))
        publisher.publish(b"junk")
        bench.spin(0.01)
    send(bench, publisher, 10.0, 8.0, drag=3.0)

    def noticed() -> bool:
        return "residual of b is " in message_of(bench)

    bench.until(noticed, "the warning")
    assert "residual of a" not in message_of(bench)
    assert bench.statuses["monitor: residual"].level in (b"\x01", b"\x02")
    values = bench.values("monitor: input")
    assert int(values["gaps"]) == 1, "two seconds without a message"
    assert int(values["bad joint state"]) >= 40
    assert "ignored" in monitor.output
    bench.until(lambda: message_of(bench) == "nothing to compare", "the silence")
    assert bench.statuses["monitor: input"].level == b"\x03"


def test_ctrl_c_twice_ends_it(bench: Bench, monitor: Process) -> None:
    monitor.signal(signal.SIGINT)
    monitor.signal(signal.SIGINT)
    assert monitor.wait() == 0
    assert "Traceback" not in monitor.output


def test_a_model_that_cannot_be_loaded_ends_it_in_words(bench: Bench) -> None:
    for params, expected in (
        ({}, "parameter model_file is empty"),
        ({"model_file": "nowhere.npz"}, "no model file"),
    ):
        process = bench.start("monitor", params=params, namespace="second")
        assert process.wait() == 2
        assert expected in process.output
        assert "Traceback" not in process.output
