"""Random messages: mostly of the right form, with values, names, sizes and stamps that are not."""

import math
from array import array
from random import Random
from typing import Any

from builtin_interfaces.msg import Duration, Time
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, MultiArrayDimension, String
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

NUMBERS = (
    *(0.0, -0.0, 1.0, -1.0, 1e-12, 5e-324, 1e3, 1e9, -1e9, 1e100, 1e308, -1.7e308),
    *(math.nan, math.inf, -math.inf),
)
NAMES = (
    "a",
    "b",
    "joint_1",
    "joint_2",
    "",
    "c",
    "é",
    "a b",
    "/",
    "\N{ROBOT FACE}" * 50,
    "x" * 3000,
)
SIZES = (0, 1, 2, 2, 2, 3, 6, 6, 7, 40)
SECONDS = (0, 1, -1, -(2**31), 2**31 - 1, 1_700_000_000)
NANOSECONDS = (0, 1, 999_999_999, 10**9, 2**32 - 1)
TEXTS = (
    *(
        "",
        "robot",
        "<robot",
        "<robot name='r'/>",
        "<a>" * 2000,
        "\0",
        "<?xml version='9'?><robot/>",
    ),
    "<!DOCTYPE r [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;'>]><robot name='&b;'/>",
    "<robot name='r'><joint name='a' type='revolute'><limit effort='nan' velocity='-1'/></joint>"
    "</robot>",
    "<robot name='r'><joint name='b' type='revolute'><limit effort='1e999'/></joint></robot>",
)


class RandomMessages:
    """Makes messages; the same seed makes the same ones.

    Args:
        seed: of the choices.
        now: ns, around which half of the stamps lie.
    """

    def __init__(self, seed: int, now: int) -> None:
        self._random = Random(seed)
        self._now = now

    def of(self, kind: type) -> Any:
        """Return a message of this kind, or the bytes of a damaged one."""
        message = getattr(self, f"_{kind.__name__}")()
        if self._random.random() > 0.15:
            return message
        data = bytearray(serialize_message(message))
        for _ in range(self._random.choice((1, 2, 8))):
            data[self._random.randrange(len(data))] = self._random.randrange(256)
        return bytes(
            data[: self._random.choice((len(data), self._random.randrange(len(data)) + 1))]
        )

    def _number(self) -> float:
        if self._random.random() < 0.6:
            return self._random.gauss(0.0, 1.0)
        return self._random.choice(NUMBERS)

    def _numbers(self, usual: int) -> "array[float]":
        size = usual if self._random.random() < 0.7 else self._random.choice(SIZES)
        if self._random.random() < 0.5:
            return array("d", (self._random.gauss(0.0, 1.0) for _ in range(size)))
        return array("d", (self._number() for _ in range(size)))

    def _names(self) -> list[str]:
        if self._random.random() < 0.6:
            return ["a", "b"]
        return self._random.choices(NAMES, k=self._random.choice(SIZES))

    def _stamp(self) -> Time:
        if self._random.random() < 0.5:
            at = self._now + round(self._random.gauss(0.0, 1e9))
            return Time(sec=at // 10**9, nanosec=at % 10**9)
        return Time(sec=self._random.choice(SECONDS), nanosec=self._random.choice(NANOSECONDS))

    def _JointState(self) -> JointState:
        names = self._names()
        values = (self._numbers(len(names)) for _ in range(3))
        message = JointState(name=names)
        message.position, message.velocity, message.effort = values
        message.header.stamp = self._stamp()
        return message

    def _JointTrajectory(self) -> JointTrajectory:
        message = JointTrajectory(joint_names=self._names())
        message.header.stamp = self._stamp()
        count = len(message.joint_names)
        for at in range(self._random.choice((0, 1, 2, 3, 30))):
            point = JointTrajectoryPoint(positions=self._numbers(count))
            if self._random.random() < 0.5:
                point.velocities, point.accelerations = self._numbers(count), self._numbers(count)
            if self._random.random() < 0.1:
                point.effort = self._numbers(count)
            point.time_from_start = Duration(sec=at, nanosec=self._random.choice(NANOSECONDS[:3]))
            if self._random.random() < 0.05:
                point.time_from_start.sec = self._random.choice(SECONDS)
            message.points.append(point)
        return message

    def _Float64MultiArray(self) -> Float64MultiArray:
        message = Float64MultiArray(data=self._numbers(self._random.choice((2, 6))))
        if self._random.random() < 0.2:
            message.layout.dim = [MultiArrayDimension(label="x", size=2**32 - 1, stride=7)]
            message.layout.data_offset = self._random.choice((0, 2**32 - 1))
        return message

    def _String(self) -> String:
        return String(data=self._random.choice(TEXTS))

    def _Clock(self) -> Clock:
        return Clock(clock=self._stamp())
