"""The alarm over DDS: a touch stands on /diagnostics before the next status of the second."""

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy")

from node_harness import Bench, heard, open_bench
from sensor_msgs.msg import JointState
from small_model import JOINTS, motion_at, torque_of

from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.nodes.common.topics import stamp
from lagrangian_ff.nodes.watching.chance import LEARNING
from lagrangian_ff.nodes.watching.touch import SETTLING
from lagrangian_ff.recording import Recording, condition

START = 1_700_000_000_000_000_000  # ns
RATE = 100.0  # Hz
NOISE = 0.05  # N·m
BEFORE = LEARNING + SETTLING + 5.0  # s


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a model that learned from a minute with noise."""
    path = tmp_path_factory.mktemp("touched")
    at = np.arange(6000) / RATE
    q, qd, qdd = motion_at(at)
    tau = torque_of(q, qd, qdd) + NOISE * np.random.default_rng(0).normal(size=q.shape)
    recording = Recording(JOINTS, at, q, qd, tau)
    settings = Settings(train=1.0, samples=200, evaluations=5)
    identify(condition(recording), settings).model.save(path / "model.npz")
    return path


@pytest.fixture(scope="module")
def bench(ros_environment: dict[str, str], folder: Path) -> Iterator[Bench]:
    with open_bench(folder) as bench:
        yield bench


def messages(seconds: float, touched: float) -> Iterator[JointState]:
    """Yield the joint states of a motion; from `touched` s on a tenth of b's torque is added."""
    at = np.arange(round(seconds * RATE)) / RATE
    q, qd, qdd = motion_at(at)
    tau = torque_of(q, qd, qdd) + NOISE * np.random.default_rng(1).normal(size=q.shape)
    tau[at >= touched, 1] += 0.1 * np.sqrt(np.mean(tau[:, 1] ** 2))
    for k, now in enumerate(at):
        message = JointState(name=list(JOINTS), position=q[k].tolist(), effort=tau[k].tolist())
        message.header.stamp = stamp(START + round(now * 1e9))
        yield message


def test_a_touch_is_on_diagnostics_within_a_tenth_of_a_second(bench: Bench, folder: Path) -> None:
    names = {"model_file": str(folder / "model.npz")}
    bench.start("monitor", params={**names, **heard("/joint_states")})
    publisher = bench.publisher(JointState, "joint_states")
    bench.until(lambda: bench.node.count_publishers("monitor/residual"), "its topics")

    def said() -> str:
        return str(getattr(bench.statuses.get("monitor: touch"), "message", ""))

    stream = messages(BEFORE + 3.0, BEFORE + 1.0)
    for k in range(round(BEFORE * RATE)):
        publisher.publish(next(stream))
        if k % 25 == 0:
            bench.spin(0.02)
    bench.until(lambda: said() == "no touch so far", "the end of its learning")
    touched = delay = float("inf")
    began = time.monotonic()
    for k, message in enumerate(stream):  # from here on in real time
        while (left := began + k / RATE - time.monotonic()) > 0.0:
            bench.spin(min(left, 0.002))
        publisher.publish(message)
        if k == round(1.0 * RATE):
            touched = time.monotonic()
        if said().startswith("touched at"):
            delay = min(delay, time.monotonic() - touched)
    assert delay < 0.1 + 0.1, "a tenth of a second, and as much for a busy machine"
    assert "b gives +" in said()
    assert bench.statuses["monitor: touch"].level == b"\x01"
    print(f"on /diagnostics {delay * 1e3:.0f} ms after the first touched message")
