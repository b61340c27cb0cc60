"""A running feedforward node with its topics, and the references to send it."""

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from builtin_interfaces.msg import Duration
from node_harness import Bench, Process
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

QUICK = {
    "ramp_time": 0.1,
    "fade_time": 0.2,
    "start_delay": 0.4,
    "reference_timeout": 0.5,
    "joint_state_timeout": 0.0,
}


class Feedforward:
    """A running node with its topics."""

    def __init__(self, bench: Bench, folder: Path, namespace: str = "", **params: Any) -> None:
        self.bench = bench
        self.name = f"/{namespace}/feedforward" if namespace else "/feedforward"
        # Deep, so that none is lost while this process is held up.
        depth = {
            f"qos_overrides.{self.name}/{topic}.publisher.depth": 5000
            for topic in ("commands", "feedforward")
        }
        self.process: Process = bench.start(
            "feedforward",
            namespace=namespace,
            params={"model_file": str(folder / "model.npz"), **QUICK, **depth, **params},
        )
        self.commands = bench.collect(Float64MultiArray, f"{self.name}/commands")
        self.stamped = bench.collect(JointState, f"{self.name}/feedforward")
        self.annotated = bench.collect(JointTrajectory, f"{self.name}/joint_trajectory")
        self.send = bench.publisher(JointTrajectory, f"{self.name}/reference")
        bench.until(lambda: self.commands, "commands")

    @property
    def tau(self) -> list[float]:
        return list(self.commands[-1][1].data)

    def until_silent(self, why: str) -> None:
        self.bench.until(lambda: not any(self.tau), f"zero torque: {why}")

    def until_sending(self, why: str) -> None:
        self.bench.until(lambda: any(self.tau), f"torque: {why}")

    def set_point(self) -> bool:
        """Send a set-point, wait a moment, and return whether its torque is sent."""
        self.send.publish(reference([0.0], [[0.2, 0.2]]))
        self.bench.spin(0.02)
        return self.tau[0] > 6.0

    def hold(self, q: float = 0.4) -> None:
        """Bring it to hold gravity at the end of a short reference."""
        self.send.publish(reference([0.0, 0.1], [[q, q], [q, q]]))
        expected = 8.0 * math.cos(q)
        self.bench.until(
            lambda: self.tau[0] == pytest.approx(expected, rel=0.002), "holding gravity"
        )


def reference(
    time: list[float], q: Any, qd: Any = None, names: tuple[str, ...] = ("a", "b")
) -> JointTrajectory:
    message = JointTrajectory(joint_names=list(names))
    for k, at in enumerate(time):
        point = JointTrajectoryPoint(positions=[float(x) for x in q[k]])
        if qd is not None:
            point.velocities = [float(x) for x in qd[k]]
        point.time_from_start = Duration(sec=int(at), nanosec=round((at % 1) * 1e9))
        message.points.append(point)
    return message


def tracked(controller: Process) -> float:
    """Return the rms error, mrad, with which the stand-in controller tracked the last goal."""
    return float(re.findall(r"goal succeeded, tracked with ([0-9.]+) mrad", controller.output)[-1])


def planned(path: Any, every: float, joints: Sequence[str]) -> JointTrajectory:
    """Return the points of a path, a `Trajectory`, as a planner gives them."""
    time = np.append(np.arange(0.0, path.time[-1], every), path.time[-1])
    message = JointTrajectory(joint_names=list(joints))
    for at, q, qd, qdd in zip(time, *path.sample(time), strict=True):
        point = JointTrajectoryPoint(
            positions=q.tolist(), velocities=qd.tolist(), accelerations=qdd.tolist()
        )
        point.time_from_start = Duration(sec=int(at), nanosec=round((at % 1) * 1e9))
        message.points.append(point)
    return message
