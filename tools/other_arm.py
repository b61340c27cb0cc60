"""Drive an arm that this package does not know, in ROS 2: an iiwa, a Panda or an xArm of PyBullet.

    .venv/bin/python tools/other_arm.py iiwa --hidden drag@3:0.1

An effect hides in a joint, counted from 1, with a share of that joint's torque. The torque is
PyBullet's inverse dynamics and friction of this file's own: nothing of it is the package's. The
Panda publishes its fingers, too, and is a driver as ros2_control's: it has the parameter `joints`,
refuses a motion of others, and begins it at its stamp. The iiwa begins it when it comes.

Topics
    joint_states                    out  sensor_msgs/JointState
    /other_arm/joint_trajectory     in   trajectory_msgs/JointTrajectory
"""

from __future__ import annotations

import argparse
import signal
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pybullet
import pybullet_data
import rclpy
from numpy.typing import NDArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

Floats = NDArray[np.float64]

STEP = 0.001  # s
WIDTH = 0.01  # rad/s, of the step of dry friction at standstill
FOLLOWS = 50.0  # 1/s, of the drives
PRESLIDING = 0.05  # rad


@dataclass(frozen=True)
class Kind:
    """An arm.

    Attributes:
        urdf: in PyBullet's data.  joints: names.  fingers: joints that are published, too.
        home: rad, where it stands.  dry: N·m.  viscous: N·m s/rad.  rotor: kg m².  noise: N·m.
        every: steps from one joint state to the next.
        stamped: whether a motion begins at its stamp.
    """

    urdf: str
    joints: tuple[str, ...]
    fingers: tuple[str, ...]
    home: tuple[float, ...]
    dry: tuple[float, ...]
    viscous: tuple[float, ...]
    rotor: tuple[float, ...]
    noise: tuple[float, ...]
    every: int
    stamped: bool


ARMS = {
    "iiwa": Kind(
        "kuka_iiwa/model.urdf",
        tuple(f"lbr_iiwa_joint_{n}" for n in range(1, 8)),
        (),
        (0.0, 0.4, 0.0, -1.2, 0.0, 0.8, 0.0),
        (3.0, 3.5, 2.0, 2.0, 1.2, 0.8, 0.5),
        (4.8, 5.6, 3.2, 2.8, 1.6, 0.8, 0.48),
        (0.9, 0.96, 0.6, 0.6, 0.27, 0.12, 0.09),
        (0.15, 0.15, 0.12, 0.12, 0.06, 0.045, 0.03),
        5,
        stamped=False,
    ),
    "panda": Kind(
        "franka_panda/panda.urdf",
        tuple(f"panda_joint{n}" for n in range(1, 8)),
        ("panda_finger_joint1", "panda_finger_joint2"),
        (0.0, -0.4, 0.0, -1.9, 0.0, 1.6, 0.7),
        (0.8, 1.0, 0.7, 0.7, 0.5, 0.4, 0.4),
        (1.0, 1.2, 0.8, 0.8, 0.5, 0.4, 0.4),
        (0.6, 0.6, 0.5, 0.5, 0.2, 0.2, 0.2),
        (0.06,) * 7,
        10,
        stamped=True,
    ),
    "xarm6": Kind(
        "xarm/xarm6_robot.urdf",
        tuple(f"joint{n}" for n in range(1, 7)),
        (),
        (0.0, -0.3, -1.1, 0.0, 1.2, 0.0),
        (1.5, 2.0, 1.4, 0.8, 0.6, 0.4),
        (2.5, 3.0, 2.0, 1.0, 0.7, 0.4),
        (0.5, 0.6, 0.4, 0.15, 0.12, 0.06),
        (0.1, 0.12, 0.08, 0.05, 0.04, 0.02),
        4,
        stamped=True,
    ),
}


@dataclass(frozen=True)
class State:
    """The moment of a joint.

    Attributes:
        q: rad.  away: rad from home.  qd: rad/s.
        load: N·m, without friction.
        bend: of the bristles of its dry friction, -1 to 1.
    """

    q: float
    away: float
    qd: float
    load: float
    bend: float

    @property
    def sign(self) -> float:
        return float(np.tanh(self.qd / WIDTH))


EFFECTS: dict[str, Callable[[State], float]] = {
    "drag": lambda x: x.qd * abs(x.qd),
    "stribeck": lambda x: x.sign * float(np.exp(-((x.qd / 0.1) ** 2))),
    "load_friction": lambda x: abs(x.load) * x.sign,
    "ripple": lambda x: float(np.sin(7.0 * x.q + 0.5)),
    "hysteresis": lambda x: x.bend,
    "tight_place": lambda x: x.sign * float(np.exp(-(((x.away - 0.2) / 0.25) ** 2))),
    "dry_spot": lambda x: x.qd * float(np.exp(-(((x.away - 0.2) / 0.25) ** 2))),
}
"""Torque of a hidden effect, but for its factor."""


class Arm:
    """The body, its gears and its drives.

    Args:
        hidden: by joint index, the name of an effect and its share of the joint's torque.
    """

    def __init__(self, kind: Kind, hidden: dict[int, tuple[str, float]], seed: int) -> None:
        self.kind, self._random = kind, np.random.default_rng(seed)
        pybullet.connect(pybullet.DIRECT)
        self.urdf = Path(pybullet_data.getDataPath()) / kind.urdf
        self._body = pybullet.loadURDF(str(self.urdf), useFixedBase=True)
        pybullet.setGravity(0.0, 0.0, -9.81)
        self.home = np.array(kind.home)
        still = np.zeros(len(self.home))
        self.q, self.qd, self.qdd = self.home.copy(), still, still
        self.bend = still.copy()
        self._hidden = {
            joint: (EFFECTS[name], self._factor(joint, EFFECTS[name], share))
            for joint, (name, share) in hidden.items()
        }

    def step(self, wanted: Floats) -> None:
        """Follow a reference (N,) rad for a step."""
        self.qdd = FOLLOWS**2 * (wanted - self.q) - 2.0 * FOLLOWS * self.qd
        self.qd = self.qd + STEP * self.qdd
        self.q = self.q + STEP * self.qd
        self.bend += STEP * (self.qd - np.abs(self.qd) * self.bend) / PRESLIDING

    def torque(self) -> Floats:
        """Return (N,) N·m, what a sensor measures."""
        load = self._load(self.q, self.qd, self.qdd)
        dry = np.array(self.kind.dry) * np.tanh(self.qd / WIDTH)
        found = load + dry + np.array(self.kind.viscous) * self.qd
        for n, (effect, factor) in self._hidden.items():
            found[n] += factor * effect(self._state(n, self.q, self.qd, load, self.bend))
        return found + self._random.normal(0.0, self.kind.noise)

    def _load(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        still = [0.0] * len(self.kind.fingers)
        states = ([*map(float, values), *still] for values in (q, qd, qdd))
        found = pybullet.calculateInverseDynamics(self._body, *states)
        return np.array(found[: len(q)]) + np.array(self.kind.rotor) * qdd

    def _state(self, n: int, q: Floats, qd: Floats, load: Floats, bend: Floats) -> State:
        away = float(q[n] - self.home[n])
        return State(float(q[n]), away, float(qd[n]), float(load[n]), float(bend[n]))

    def _factor(self, n: int, effect: Callable[[State], float], share: float) -> float:
        """Return the factor with which an effect has a share of the torque in random motion."""
        random = np.random.default_rng(0)
        torques, effects, count = [], [], len(self.home)
        for _ in range(2000):
            q = self.home + random.uniform(-1.2, 1.2, count)
            qd, qdd = random.normal(0.0, 0.6, count), random.normal(0.0, 1.5, count)
            load = self._load(q, qd, qdd)
            slip = self.kind.dry[n] * np.sign(qd[n]) + self.kind.viscous[n] * qd[n]
            torques.append(load[n] + slip)
            effects.append(effect(self._state(n, q, qd, load, random.uniform(-1.0, 1.0, count))))
        return float(share * np.std(torques) / np.std(effects))


class Driver(Node):
    """Publishes the arm's states and takes motions."""

    def __init__(self, arm: Arm) -> None:
        super().__init__("other_arm")
        self._arm, self._names = arm, (*arm.kind.joints, *arm.kind.fingers)
        self._states = self.create_publisher(JointState, "joint_states", 10)
        self.create_subscription(JointTrajectory, "/other_arm/joint_trajectory", self._take, 10)
        if arm.kind.stamped:
            self.declare_parameter("joints", list(arm.kind.joints))
        self._motion: tuple[float, Floats, Floats, Floats] | None = None

    def publish(self) -> None:
        """Publish the state of now."""
        still = [0.0] * len(self._arm.kind.fingers)
        message = JointState(
            name=self._names,
            position=[*self._arm.q.tolist(), *still],
            velocity=[*self._arm.qd.tolist(), *still],
            effort=[*self._arm.torque().tolist(), *still],
        )
        message.header.stamp = self.get_clock().now().to_msg()
        self._states.publish(message)

    def _take(self, message: JointTrajectory) -> None:
        if sorted(message.joint_names) != sorted(self._arm.kind.joints):
            self.get_logger().error(f"no motion of {', '.join(message.joint_names)}")
            return
        order = [message.joint_names.index(name) for name in self._arm.kind.joints]
        at = [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in message.points]
        q = np.array([p.positions for p in message.points])[:, order]
        qd = np.array([p.velocities for p in message.points])[:, order]
        stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        begins = time.monotonic()
        if self._arm.kind.stamped and stamp:
            begins += stamp - 1e-9 * self.get_clock().now().nanoseconds
        self._motion = begins, np.array(at), q, qd

    def wanted(self, now: float) -> Floats:
        """Return (N,) rad, where the arm is to be at an instant of the monotonic clock, s."""
        if self._motion is None:
            return self._arm.home
        begins, at, q, qd = self._motion
        since = float(np.clip(now - begins, at[0], at[-1]))
        k = int(np.clip(np.searchsorted(at, since) - 1, 0, len(at) - 2))
        long = at[k + 1] - at[k]
        u = (since - at[k]) / long
        return (  # the cubic of Hermite
            q[k] * (1.0 + 2.0 * u) * (1.0 - u) ** 2
            + q[k + 1] * u**2 * (3.0 - 2.0 * u)
            + long * u * (1.0 - u) * (qd[k] * (1.0 - u) - qd[k + 1] * u)
        )


def hidden_in(text: str) -> tuple[int, tuple[str, float]]:
    """Return the joint's index, the effect and its share of EFFECT@JOINT:SHARE."""
    name, _, rest = text.partition("@")
    joint, _, share = rest.partition(":")
    if name not in EFFECTS or joint not in map(str, range(1, 8)):
        raise argparse.ArgumentTypeError(f"{text}: expected one of {', '.join(EFFECTS)} @1 to @7")
    return int(joint) - 1, (name, float(share))


def asked_for(parser: argparse.ArgumentParser) -> tuple[Arm, argparse.Namespace]:
    """Return the arm that the command line names, and all that was given."""
    parser.add_argument("arm", choices=ARMS)
    parser.add_argument("--hidden", type=hidden_in, nargs="*", default=[])
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    count = len(ARMS[given.arm].joints)
    if wrong := [joint + 1 for joint, _ in given.hidden if joint >= count]:
        parser.error(f"--hidden in joint {wrong[0]}: the {given.arm} has {count} joints")
    return Arm(ARMS[given.arm], dict(given.hidden), given.seed), given


def main() -> None:
    """Drive the arm until the process is ended."""
    summary = __doc__.split("\n")[0] if __doc__ else ""
    arm, _ = asked_for(argparse.ArgumentParser(description=summary))
    # rclpy's own handlers end the context below the publisher, and do not always wake the executor.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    driver = Driver(arm)
    executor = SingleThreadedExecutor()
    executor.add_node(driver)
    spinning = threading.Thread(target=executor.spin, daemon=True)
    spinning.start()
    now, steps = time.monotonic(), 0
    with suppress(KeyboardInterrupt):
        print(f"lagrangian_ff investigate --topic /other_arm/joint_trajectory --urdf {arm.urdf}")
        while True:
            arm.step(driver.wanted(now))
            now, steps = now + STEP, steps + 1
            if steps % arm.kind.every == 0:
                driver.publish()
            time.sleep(max(0.0, now - time.monotonic()))
    executor.shutdown()
    spinning.join(5.0)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
