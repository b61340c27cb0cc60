"""What the faults befall: feedforward and watchdog as processes, a robot, and who watches."""

import math
import os
import re
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torque_watch
from builtin_interfaces.msg import Duration, Time
from diagnostic_msgs.msg import DiagnosticArray
from node_harness import RELIABLE, Bench, Process
from numpy.typing import NDArray
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from small_model import save_small_model
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

LIMIT, RATE = 12.0, 240.0  # N·m, N·m/s
PERIODS = 3.0  # that one message makes up for at most
SETTINGS = {
    "ramp_time": 0.1,
    "fade_time": 0.2,
    "start_delay": 0.2,
    "reference_timeout": 0.3,
    "joint_state_timeout": 0.3,
    **{f"limits.{joint}.effort": LIMIT for joint in "ab"},
    **{f"limits.{joint}.effort_rate": RATE for joint in "ab"},
}
TIMES = {**SETTINGS, "watchdog timeout": 0.1, "watchdog fade_time": 0.2}
Q = 0.4  # rad, where the arm is held
MAIN, GUARD = "/feedforward/commands", "/watchdog/commands"


@dataclass(frozen=True)
class Shot:
    """A fault that was injected.

    Attributes:
        at: when, s of the monotonic clock; now if not given.
        topic: of the torques to look at.
        tau: N·m that joint a comes to; None where the row says enough.
        restarts: whether the sender is started again, whose first torque is zero.
        later: whether /diagnostics can speak only after the fault is over.
        rate: Hz of the stream.
    """

    topic: str = MAIN
    tau: float | None = None
    restarts: bool = False
    later: bool = False
    rate: float = 500.0
    at: float = field(default_factory=time.monotonic)


def held(q: float = Q) -> float:
    """Return the torque that holds a joint, N·m."""
    return 8.0 * math.cos(q)


def stamp(at: int) -> Time:
    return Time(sec=at // 10**9, nanosec=at % 10**9)


def reference(
    time: Sequence[float], q: Any, names: tuple[str, ...] = ("a", "b"), qdd: float | None = None
) -> JointTrajectory:
    """Return a trajectory that begins now."""
    message = JointTrajectory(joint_names=list(names))
    for at, row in zip(time, q, strict=True):
        point = JointTrajectoryPoint(positions=[float(x) for x in row])
        if qdd is not None:
            point.velocities, point.accelerations = [0.0, 0.0], [qdd, qdd]
        point.time_from_start = Duration(sec=int(at), nanosec=round((at % 1) * 1e9))
        message.points.append(point)
    return message


class Robot:
    """Publishes joint states, and set-points if there are some, 100 times a second.

    Attributes:
        position: rad, of both joints.
        make: the joint states to publish at a time in ns; the faults change it.
        setpoint: q and qdd to send; None for none.
        simulated: ns of /clock; None to publish none. `speed` 0 makes it stand.
    """

    def __init__(self, bench: Bench) -> None:
        create = bench.node.create_publisher
        self._clock = bench.node.get_clock()
        self._states = [create(JointState, "/joint_states", RELIABLE) for _ in range(2)]
        self._simulated_states = create(JointState, "/simulated/joint_states", RELIABLE)
        self._time = create(Clock, "/clock", RELIABLE)
        self.references = create(JointTrajectory, "/feedforward/reference", RELIABLE)
        self.simulated: int | None = None
        self.speed = 1
        self.reset()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def reset(self) -> None:
        """Be healthy and stand at `Q`."""
        self.position = Q
        self.setpoint: tuple[float, float] | None = None
        self.make: Callable[[int], list[JointState]] = lambda now: [self.state(now)]

    def state(self, at: int, names: str = "ab", shift: float = 0.0) -> JointState:
        """Return a joint state with this stamp."""
        message = JointState(name=list(names), position=[self.position + shift] * len(names))
        message.header.stamp = stamp(at)
        return message

    def _run(self) -> None:
        while not self._stop.wait(0.01):
            for publisher, message in zip(
                self._states, self.make(self._clock.now().nanoseconds), strict=False
            ):
                publisher.publish(message)
            if self.setpoint is not None:
                q, qdd = self.setpoint
                self.references.publish(reference([0.0], [[q, q]], qdd=qdd))
            if self.simulated is not None:
                self.simulated += self.speed * 10_000_000
                self._time.publish(Clock(clock=stamp(self.simulated)))
                self._simulated_states.publish(self.state(self.simulated))

    def stop(self) -> None:
        self._stop.set()
        self._thread.join(2.0)


class World:
    """The processes, the robot, the process that watches, and what /diagnostics said."""

    def __init__(self, bench: Bench, folder: Path, namespaces: Sequence[str]) -> None:
        self.bench, self.folder = bench, folder
        self.model = folder / "model.npz"
        save_small_model(self.model)
        self.sound = self.model.read_bytes()
        self._topics = [f"{ns}/feedforward/commands" for ns in ("", *namespaces)]
        self._topics.append("/watchdog/commands")
        self._records = torque_watch.Records(folder / "torques")
        self._watched: dict[str, list[NDArray[np.float64]]] = {topic: [] for topic in self._topics}
        self._pauses: list[tuple[float, float]] = []
        self.sizes: set[float] = set()
        self._watch = subprocess.Popen(
            [sys.executable, torque_watch.__file__, str(self._records.path), *self._topics],
            start_new_session=True,
        )
        self.said: list[str] = []
        bench.node.create_subscription(DiagnosticArray, "/diagnostics", self._on_said, 100)
        self.robot = Robot(bench)
        self._main: Process | None = None
        self._guard: Process | None = None

    def close(self) -> None:
        self.robot.stop()
        self._watch.kill()
        self._watch.wait()

    def _on_said(self, message: DiagnosticArray) -> None:
        for status in message.status:
            values = (f"{pair.key}: {pair.value}" for pair in status.values)
            self.said.append("\n".join([f"{status.name}: {status.message}", *values]))

    def spoke(self, expected: str) -> bool:
        """Return whether /diagnostics said this since `said` was cleared; "" is always said."""
        return not expected or any(re.search(expected, text) for text in self.said)

    def start(self, namespace: str = "", **params: Any) -> Process:
        """Start a feedforward."""
        given = {"model_file": str(self.model), **SETTINGS, **params}
        return self.bench.start("feedforward", namespace=namespace, params=given)

    @property
    def main(self) -> Process:
        """Return the feedforward that most faults befall, started if there is none."""
        if self._main is None or not self._main.alive:
            self._main = self.start()
            self.settle()
        return self._main

    @property
    def guard(self) -> Process:
        """Return the watchdog behind it, started if there is none."""
        if self._guard is None or not self._guard.alive:
            limits = {name: value for name, value in SETTINGS.items() if name.startswith("limits")}
            times = {"timeout": 0.1, "fade_time": 0.2, "joints": ["a", "b"]}
            self._guard = self.bench.start("watchdog", params={**times, **limits})
        return self._guard

    def records(self, topic: str, since: float = 0.0) -> NDArray[np.float64]:
        """Return when messages came (s, monotonic) and their torques, (K, 3)."""
        recent = [part for part in self._watched[topic] if part[-1, 0] >= since]
        found = np.concatenate([np.empty((0, 3)), *recent])
        return found[found[:, 0] >= since]

    def look(self) -> None:
        """Read what was watched since the last call."""
        new = self._records.read()
        paused = new[:, 1] == torque_watch.PAUSED
        self._pauses.extend((float(row[0]), float(row[2])) for row in new[paused])
        self.sizes.update(new[~paused, 2].tolist())
        for index, topic in enumerate(self._topics):
            part = new[new[:, 1] == index][:, [0, 3, 4]]
            if len(part):
                self._watched[topic].append(part)

    def pause(self, since: float) -> float:
        """Return how long the process that watches stood still at most since then, s."""
        self.look()
        return max((lasted for ended, lasted in self._pauses if ended > since), default=0.0)

    def tau(self, topic: str) -> NDArray[np.float64]:
        """Return the last torques that came, zeros without any."""
        self.look()
        parts = self._watched[topic]
        return parts[-1][-1, 1:] if parts else np.zeros(2)

    def all_torques(self) -> NDArray[np.float64]:
        """Return the torques (K, 2) of all messages of all topics."""
        self.look()
        return np.concatenate([part[:, 1:] for parts in self._watched.values() for part in parts])

    def until(self, condition: Callable[[], Any], what: str, patience: float = 30.0) -> None:
        self.bench.until(condition, what, patience)

    def until_tau(self, topic: str, wanted: float) -> None:
        """Wait until joint a has this torque, N·m."""
        self.until(
            lambda: abs(self.tau(topic)[0] - wanted) < 0.02 * abs(wanted),
            f"{wanted:.2f} N·m on {topic}",
        )

    def settle(self, topic: str = "/feedforward/commands") -> None:
        """Wait for the first torque after a start, zero."""
        begin = time.monotonic()

        def came() -> int:
            self.look()
            return len(self.records(topic, begin))

        self.until(came, f"torques on {topic}")

    def hold(self, namespace: str = "") -> None:
        """Let a healthy feedforward hold the arm at `Q`."""
        topic = f"{namespace}/feedforward/commands"
        send = self.robot.references
        if namespace:
            send = self.bench.publisher(JointTrajectory, f"{namespace}/feedforward/reference")
        self.send(reference([0.0, 0.1], [[Q, Q], [Q, Q]]), topic, held(), send)

    def send(self, message: JointTrajectory, topic: str, tau: float, publisher: Any = None) -> None:
        """Send a reference until its torque comes: readers that died are still listed a while."""
        sent = -math.inf

        def there() -> bool:
            nonlocal sent
            if time.monotonic() - sent > 1.5:
                sent = time.monotonic()
                (publisher or self.robot.references).publish(message)
            return bool(abs(self.tau(topic)[0] - tau) < 0.02 * abs(tau))

        self.until(there, f"{tau:.2f} N·m on {topic}")

    def stream(self, q: float = 0.2) -> None:
        """Let it follow set-points, which go on."""
        self.robot.position, self.robot.setpoint = q, (q, 0.0)
        self.until_tau("/feedforward/commands", held(q))

    def usual(self) -> None:
        """Be healthy again: feedforward and watchdog alive, the arm held."""
        self.robot.reset()
        if self.model.read_bytes() != self.sound if self.model.exists() else True:
            self.model.write_bytes(self.sound)
        assert self.main.alive
        assert self.guard.alive
        self.hold()
        self.until_tau("/watchdog/commands", held())

    def threads(self, process: Process) -> list[int]:
        """Return the ids of all threads of a process."""
        return [int(task) for task in os.listdir(f"/proc/{process.pid}/task")]
