"""Faulty sensors: late or clipped effort, an encoder off its axis."""

from collections import deque
from math import cos, pi

import numpy as np

from lagrangian_ff.arm.hidden.base import Installed, Site, unexplained_by
from lagrangian_ff.arm.servo import SensorEffect
from lagrangian_ff.arrays import Floats


class LateEffort(SensorEffect):
    """The driver reports the effort of d seconds ago beside the present position.

    Effort is linear between samples. The delay of one joint is that of its bus node.
    """

    def __init__(self, joint: int, delay: float) -> None:
        self.joint, self.delay = joint, delay
        self._held: deque[tuple[float, float]] = deque()

    def reset(self) -> None:
        self._held.clear()

    def sense(self, time: float, position: Floats, effort: Floats) -> tuple[Floats, Floats]:
        held, then = self._held, time - self.delay
        held.append((time, float(effort[self.joint])))
        while len(held) > 1 and held[1][0] <= then:
            held.popleft()
        late = effort.copy()
        late[self.joint] = held[0][1]
        if len(held) > 1 and then > held[0][0]:
            part = (then - held[0][0]) / (held[1][0] - held[0][0])
            late[self.joint] += part * (held[1][1] - held[0][1])
        return position, late


def delay(site: Site, strength: float) -> Installed:
    """Install a delay of strength s."""
    return Installed(sensors=(LateEffort(site.joint, strength),), facts={"delay [s]": strength})


def delay_torque(installed: Installed, site: Site) -> Floats:
    """Return the reported torque less the true one."""
    (sensor,) = installed.sensors
    assert isinstance(sensor, LateEffort)
    run, true = site.along, site.along.motor[:, sensor.joint]
    late = np.interp(run.time - sensor.delay, run.time, true)
    return _on_joint(site, sensor.joint, late - true)


class ClippedEffort(SensorEffect):
    """A current sensor whose range ends below what the motor draws."""

    def __init__(self, joint: int, limit: float) -> None:
        self.joint, self.limit = joint, limit

    def sense(self, time: float, position: Floats, effort: Floats) -> tuple[Floats, Floats]:
        clipped = effort.copy()
        clipped[self.joint] = min(max(float(effort[self.joint]), -self.limit), self.limit)
        return position, clipped


def saturation(site: Site, strength: float) -> Installed:
    """Install a limit at 1 − strength of the largest torque of the run."""
    limit = (1.0 - strength) * float(np.abs(site.along.motor[:, site.joint]).max())
    return Installed(sensors=(ClippedEffort(site.joint, limit),), facts={"limit [N·m]": limit})


def saturation_torque(installed: Installed, site: Site) -> Floats:
    """Return the reported torque less the true one."""
    (sensor,) = installed.sensors
    assert isinstance(sensor, ClippedEffort)
    true = site.along.motor[:, sensor.joint]
    clipped = np.clip(true, -sensor.limit, sensor.limit)
    return _on_joint(site, sensor.joint, clipped - true)


def _on_joint(site: Site, joint: int, values: Floats) -> Floats:
    """Return (M, 6) N·m: values (M,) on a joint, zero on the others."""
    torque = np.zeros_like(site.along.motor)
    torque[:, joint] = values
    return torque


class OffAxis(SensorEffect):
    """An encoder disk off its axis reads q + e cos(q + phase), once a turn of the joint."""

    def __init__(self, joint: int, error: float, phase: float) -> None:
        self.joint, self.error, self.phase = joint, error, phase

    def sense(self, time: float, position: Floats, effort: Floats) -> tuple[Floats, Floats]:
        read = position.copy()
        read[self.joint] += self.error * cos(float(position[self.joint]) + self.phase)
        return read, effort


def eccentricity(site: Site, strength: float) -> Installed:
    """Install an error of strength rad, at a random phase."""
    phase = site.random.uniform(0.0, 2.0 * pi)
    return Installed(
        sensors=(OffAxis(site.joint, strength, phase),),
        facts={"error [rad]": strength, "phase [rad]": phase},
    )


def eccentricity_torque(installed: Installed, site: Site) -> Floats:
    """Return the torque of the true motion less that of the reported one."""
    (sensor,) = installed.sensors
    assert isinstance(sensor, OffAxis)
    run, j, error = site.along, sensor.joint, sensor.error
    angle = run.q[:, j] + sensor.phase
    rate = 1.0 - error * np.sin(angle)
    q, qd, qdd = run.q.copy(), run.qd.copy(), run.qdd.copy()
    q[:, j] += error * np.cos(angle)
    qd[:, j] *= rate
    qdd[:, j] = qdd[:, j] * rate - error * np.cos(angle) * run.qd[:, j] ** 2
    return unexplained_by(site, q, qd, qdd)
