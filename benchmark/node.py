"""The feedforward node at 1 kHz: from a set-point in to its torque out, over DDS.

A process sends set-points of 6 joints at 1 kHz, the node runs the default model with its stream at
1 kHz, and this process receives. Prints how many set-points the node followed, how many it left out
because the next had come before its tick, and how many it never got (bound: none); and the median
and the 99th percentile (bound 3 ms) of the time from sending a set-point to the first command that
is of it or of one after it, seen in ~/feedforward, which is sent after each command. And, for what
of it is the machine's own, the same of a loop that wakes at 1 kHz and does nothing.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from timing import moving

BOUND = 3.0  # ms
RATE = 1000.0
TRAIN_RATE = 100.0
JOINTS = tuple(f"joint_{n + 1}" for n in range(6))
STEP = 1e-6  # rad, by which each set-point differs from the one before: its number
PATIENCE = 60.0  # s
LEAVE = 2.0  # s, in which what is under way arrives

Floats = NDArray[np.float64]


def main() -> None:
    """Make a model, start everything, measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--model", default="auto+fri")
    options = parser.parse_args()
    os.environ["ROS_DOMAIN_ID"] = str(os.getpid() % 100 + 1)
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "model.npz"
        middle = make_model(file, options.model)
        node = subprocess.Popen(node_command(file), start_new_session=True)
        here, there = get_context("spawn").Pipe()
        count = round(options.seconds * RATE)
        sender = get_context("spawn").Process(target=send, args=(there, middle, count))
        sender.start()
        try:
            report(*receive(here, middle, count))
            idle = np.quantile(bare(count), (0.5, 0.99, 1.0))
            print(
                "a bare loop: median {:.2f} ms, 99th percentile {:.2f} ms, worst {:.1f} ms".format(
                    *idle
                )
            )
        finally:
            sender.join(5.0)
            node.terminate()
            node.wait(10.0)


def make_model(file: Path, name: str) -> Floats:
    """A model of the benchmark's motion; (N,) the middle of its range."""
    from lagrangian_ff.identification import Settings, identify
    from lagrangian_ff.recording.motion import Motion

    time_ = np.arange(0.0, 40.0, 1.0 / TRAIN_RATE)
    q, qd, qdd, tau = moving(np.random.default_rng(0), time_, len(JOINTS))
    segment = np.zeros(len(time_), dtype=np.int64)
    motion = Motion(JOINTS, time_, q, qd, qdd, tau, segment, "benchmark")
    found = identify(motion, Settings(model=name, train=1.0, evaluations=15))
    found.model.save(file)
    return np.asarray(0.5 * (q.min(axis=0) + q.max(axis=0)))


def node_command(file: Path) -> list[str]:
    """How the node is started."""
    values = {"model_file": file, "rate": RATE, "joint_state_timeout": 0.0, "ramp_time": 0.001}
    given = [part for name, value in values.items() for part in ("-p", f"{name}:={value}")]
    return [sys.executable, "-m", "lagrangian_ff.nodes.feedforward", "--ros-args", *given]


def send(pipe: Connection, middle: Floats, count: int) -> None:
    """Send set-points once the other side is ready, then tell when each was sent, in ns."""
    import rclpy
    from builtin_interfaces.msg import Duration
    from rclpy.qos import QoSProfile
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    from lagrangian_ff.nodes.common.pacing import Pacer

    rclpy.init()
    node = rclpy.create_node("sender")
    publisher = node.create_publisher(
        JointTrajectory, "/feedforward/reference", QoSProfile(depth=100)
    )
    point = JointTrajectoryPoint(time_from_start=Duration())
    point.velocities = point.accelerations = [0.1] * len(JOINTS)
    message = JointTrajectory(joint_names=list(JOINTS), points=[point])
    began = time.monotonic()
    while publisher.get_subscription_count() == 0 and time.monotonic() - began < PATIENCE:
        time.sleep(0.05)
    pipe.send("ready")
    pipe.recv()
    sent = np.zeros(count, dtype=np.int64)
    pacer, number = Pacer(1.0 / RATE, most=1_000_000, skip=False), 0
    while number < count:
        for _ in pacer.wait():
            if number < count:
                point.positions = [float(middle[0] + number * STEP), *map(float, middle[1:])]
                sent[number] = time.time_ns()
                publisher.publish(message)
                number += 1
    pipe.send(sent)
    time.sleep(LEAVE)
    rclpy.shutdown()


def receive(pipe: Connection, middle: Floats, count: int) -> tuple[Floats, int, int, int]:
    """Take all that the node says, by the time at which DDS had it.

    Returns:
        Milliseconds to the first command of each set-point; how many the node says it followed,
        and superseded; and how many were sent.
    """
    import rclpy
    from diagnostic_msgs.msg import DiagnosticArray
    from rclpy.qos import QoSProfile
    from rclpy.serialization import deserialize_message
    from sensor_msgs.msg import JointState

    from lagrangian_ff.nodes.common.topics import PolledSubscription

    rclpy.init()
    node = rclpy.create_node("receiver")
    deep = QoSProfile(depth=5000)
    states = PolledSubscription(node, JointState, "/feedforward/feedforward", deep, raw=True)
    diagnostics = PolledSubscription(node, DiagnosticArray, "/diagnostics", deep)
    assert pipe.recv() == "ready"
    time.sleep(1.0)
    pipe.send("go")
    commands: list[tuple[bytes, int]] = []
    followed = superseded = 0
    until = time.monotonic() + count / RATE + LEAVE
    while time.monotonic() < until:
        time.sleep(0.02)
        commands.extend(states.take())
        for message, _ in diagnostics.take():
            values = {pair.key: pair.value for status in message.status for pair in status.values}
            followed = int(values.get("references followed", followed))
            superseded = int(values.get("set-points superseded", superseded))
    sent = pipe.recv()
    at = np.array([moment for _, moment in commands])
    number = np.array(
        [
            round((deserialize_message(data, JointState).position[0] - middle[0]) / STEP)
            for data, _ in commands
        ]
    )
    rclpy.shutdown()
    # Set-points only ever rise: the first command at or past a number is the one that met it.
    order = np.argsort(at)
    reached = np.maximum.accumulate(number[order])
    first = np.searchsorted(reached, np.arange(count))
    met = first < len(reached)
    return (at[order][first[met]] - sent[met]) / 1e6, followed, superseded, count


def bare(count: int) -> Floats:
    """Milliseconds from each instant, half a period before a tick, to the tick that meets it."""
    period = round(1e9 / RATE)
    start, wakes = time.monotonic_ns(), np.zeros(count, dtype=np.int64)
    for k in range(count):
        left = start + k * period - time.monotonic_ns()
        if left > 0:
            time.sleep(left / 1e9)
        wakes[k] = time.monotonic_ns()
    instants = start + period * np.arange(count) - period // 2
    return (wakes[np.searchsorted(wakes, instants)] - instants) / 1e6


def report(milliseconds: Floats, followed: int, superseded: int, sent: int) -> None:
    """Print it."""
    median, tail, worst = np.quantile(milliseconds, (0.5, 0.99, 1.0))
    print(
        f"{sent} set-points at {RATE:g} Hz: {followed} followed, {superseded} superseded, "
        f"{sent - followed - superseded} lost (bound 0); median {median:.2f} ms, 99th percentile "
        f"{tail:.2f} ms (bound {BOUND:g}), worst {worst:.1f} ms"
    )


if __name__ == "__main__":
    main()
