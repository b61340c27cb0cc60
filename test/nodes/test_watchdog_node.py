"""The watchdog as a process: what the controller gets from it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from node_harness import Bench, open_bench
from std_msgs.msg import Float64MultiArray

LIMIT, RATE = 12.0, 240.0  # N·m, N·m/s
LONGEST = 0.006  # s that one message makes up for at most


@pytest.fixture
def bench(ros_environment: dict[str, str], tmp_path: Path) -> Iterator[Bench]:
    with open_bench(tmp_path) as bench:
        yield bench


def test_torques_far_apart_are_brought_in_without_a_jump(bench: Bench) -> None:
    """The torque moves between two messages, and each move is sent."""
    limits: dict[str, Any] = {"limits.a.effort": LIMIT, "limits.a.effort_rate": RATE}
    times = {"timeout": 0.5, "ramp_time": 0.1, "fade_time": 0.2}
    process = bench.start("watchdog", params={"joints": ["a"], **times, **limits})
    came = bench.collect(Float64MultiArray, "watchdog/commands")
    send = bench.publisher(Float64MultiArray, "feedforward/commands")
    for wanted in (10.0, -10.0, 10.0):
        for _ in range(8):
            send.publish(Float64MultiArray(data=[wanted]))
            bench.spin(0.05)
    bench.until(lambda: came and abs(came[-1][1].data[0] - 10.0) < 1e-9, "the last torque")
    sent = np.array([0.0, *(message.data[0] for _, message in came)])
    assert sent.min() < -9.9
    assert process.alive
    assert np.abs(np.diff(sent)).max() <= RATE * LONGEST + 1e-9
