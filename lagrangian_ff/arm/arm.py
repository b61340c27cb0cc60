"""The arm: a reference and a feedforward go in, joint states come out."""

from collections.abc import Sequence
from math import isfinite
from typing import NamedTuple

import numpy as np

from lagrangian_ff.arm.description import HOME, JOINTS, Loads, limits
from lagrangian_ff.arm.joint_effect import JointEffect
from lagrangian_ff.arm.parameters import ArmParameters
from lagrangian_ff.arm.plant import Attached, Gear, Plant
from lagrangian_ff.arm.servo import CurrentLoop, PositionLoop, SensorEffect, Sensors
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ArmError


class JointSample(NamedTuple):
    """The driver's report of one instant.

    Attributes:
        time: s since the reset.
        position: (6,) rad.  velocity: (6,) rad/s.
        effort: (6,) N·m, the measured current through torque constant and gear.
    """

    time: float
    position: Floats
    velocity: Floats
    effort: Floats


class Arm:
    """Plant, servo and sensors, stepped at the rate of the measurements.

    Args:
        parameters: drives, servo and sensors.
        seed: of the noise; the same seed and inputs give the same samples.
        loads: kg (or Load) by joint or link.
        effects: further effects in the joints of the plant.
        sensors: faults of the measurements.
        gears: that are elastic or have play.
        attached: loads that replace `loads` at a later time.

    Attributes:
        torques: (4, 6) N·m, means of the last tick: of the motors through the gears; of that what
            friction and effects took; the effects besides friction; what went into the links.
        saturated: (6,) whether the torque asked for was cut at the limit in the last tick.
    """

    joints = JOINTS

    def __init__(
        self,
        parameters: ArmParameters | None = None,
        *,
        seed: int = 0,
        loads: Loads = None,
        effects: Sequence[JointEffect] = (),
        sensors: Sequence[SensorEffect] = (),
        gears: Sequence[Gear] = (),
        attached: Attached | None = None,
    ) -> None:
        self.parameters = parameters or ArmParameters()
        self.plant = Plant(self.parameters, loads, effects, attached, gears)
        self._current = CurrentLoop(self.parameters)
        self._position = PositionLoop(self.parameters)
        self._sensors = Sensors(self.parameters, seed, sensors)
        self._limit = limits().effort
        self._substeps = self.parameters.physics_rate // self.parameters.sample_rate
        self._ticks_per_update = self.parameters.sample_rate // self.parameters.position_rate
        self.reset(np.array(HOME))

    def reset(self, q: Floats) -> None:
        """Put the arm at rest at q (6,) rad; currents, clock and noise start again.

        Raises:
            ArmError: q is not finite or outside the limits; names the joint.
        """
        q = self._checked("start position", q)
        low, high, *_ = limits()
        for n in np.flatnonzero((q < low) | (q > high)):
            raise ArmError(
                f"start position of {JOINTS[n]} is {q[n]:.4f} rad, outside its limits "
                f"{low[n]:.3f} to {high[n]:.3f} rad"
            )
        self._ticks = 0
        self._feedback = np.zeros(len(JOINTS))
        self.torques = np.zeros((4, len(JOINTS)))
        self.saturated = np.zeros(len(JOINTS), dtype=bool)
        self.plant.reset(q)
        for part in (self._current, self._position, self._sensors):
            part.reset()

    @property
    def time(self) -> float:
        """Return the time since the reset, s."""
        return self._ticks * self.parameters.tick

    def step(self, q_ref: Floats, qd_ref: Floats, feedforward: Floats | None = None) -> JointSample:
        """Measure, control, and advance by one tick.

        Args:
            q_ref: (6,) rad, the reference now.  qd_ref: (6,) rad/s.
            feedforward: (6,) N·m added to the torque of the position loop; None for none.

        Returns:
            The measurement at the beginning of the tick, the instant of q_ref.

        Raises:
            ArmError: an input that is not six finite numbers; names joint and time. The arm has
                not moved then.
        """
        q_ref = self._checked("reference position", q_ref)
        qd_ref = self._checked("reference velocity", qd_ref)
        if feedforward is not None:
            feedforward = self._checked("feedforward torque", feedforward)
        position, velocity, effort = self._sensors.sample(self.plant.encoder, self._current.current)
        sample = JointSample(self.time, position, velocity, effort)
        if self._ticks % self._ticks_per_update == 0:
            self._feedback = self._position.torque(q_ref, qd_ref, position)
        wanted = self._feedback if feedforward is None else self._feedback + feedforward
        command = np.minimum(np.maximum(wanted, -self._limit), self._limit)
        self.saturated = command != wanted
        plant = self.plant
        sums = np.zeros(plant.torques.shape)
        for _ in range(self._substeps):
            plant.step(self._current.step(command, plant.rotor_velocity))
            sums += plant.torques
        self.torques = sums / self._substeps
        self._ticks += 1
        return sample

    def _checked(self, what: str, values: Floats) -> Floats:
        array = np.asarray(values, dtype=np.float64)
        if array.shape != (len(JOINTS),):
            raise ArmError(
                f"{what}: expected {len(JOINTS)} values ({', '.join(JOINTS)}), "
                f"got shape {array.shape}"
            )
        # The sum of squares is finite if all are, but for absurd numbers; it takes a third of the
        # time of checking each.
        if not (isfinite(array.dot(array)) or np.isfinite(array).all()):
            n = int(np.argmin(np.isfinite(array)))
            when = getattr(self, "_ticks", 0) * self.parameters.tick
            raise ArmError(f"{what} of {JOINTS[n]} at {when:.3f} s is {array[n]}, not a number")
        return array

    def close(self) -> None:
        """End PyBullet's world."""
        self.plant.close()
