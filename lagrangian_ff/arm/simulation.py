"""Drive the simulated arm along a trajectory, faster than real time, and record it."""

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arm.arm import Arm
from lagrangian_ff.arm.body import check_clearance
from lagrangian_ff.arm.description import JOINTS, Loads
from lagrangian_ff.arm.joint_effect import JointEffect
from lagrangian_ff.arm.parameters import ArmParameters
from lagrangian_ff.arm.plant import Attached, Gear
from lagrangian_ff.arm.servo import SensorEffect
from lagrangian_ff.arm.trajectory import Trajectory, check_limits
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ArmError
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.recording import Recording

Torque = Callable[[Floats, Floats, Floats], Floats]
Feedforward = Literal["true", "trajectory"] | Torque | Floats | None

SETTLING = 1.0  # s at the start pose before the record begins


@dataclass(frozen=True)
class Run:
    """A run along a trajectory: the measurements, and values that only a simulator knows.

    Attributes:
        recording: joint states as the driver reports them.
        reference: the trajectory at the instants of the recording.
        feedforward: (M, 6) N·m that was added.
        position: (M, 6) rad and velocity: (M, 6) rad/s of the links, without the sensors' errors.
        encoder: (M, 6) rad of the motors through the gears; equals position for stiff gears.
        motor_torque: (M, 6) N·m through the gears, mean of the tick after each sample.
        effect_torque: (M, 6) N·m of it lost to friction and effects.
        added_torque: (M, 6) N·m of it lost to the effects besides friction.
        load_torque: (M, 6) N·m of it that went into the links.
        saturated: (M, 6) whether the torque was cut at the limit.
    """

    recording: Recording
    reference: Trajectory
    feedforward: Floats
    position: Floats
    encoder: Floats
    velocity: Floats
    motor_torque: Floats
    effect_torque: Floats
    added_torque: Floats
    load_torque: Floats
    saturated: NDArray[np.bool_]

    @property
    def tracking_error(self) -> Floats:
        """Return (M, 6) rad, reference less measured position."""
        return self.reference.q - self.recording.position


def simulate(
    trajectory: Trajectory,
    feedforward: Feedforward = None,
    *,
    parameters: ArmParameters | None = None,
    loads: Loads = None,
    effects: Sequence[JointEffect] = (),
    sensors: Sequence[SensorEffect] = (),
    gears: Sequence[Gear] = (),
    attached: Attached | None = None,
    seed: int = 0,
    progress: Progress = silent,
) -> Run:
    """Drive the arm along a trajectory; return the run.

    Args:
        trajectory: the reference; the arm starts at rest at its first point.
        feedforward: torque added to the position loop. None; a function (q, qd, qdd) -> tau of
            (M, 6) arrays, such as a model's `predict`; an array (K, 6) N·m at the points of the
            trajectory, linear between them; "trajectory" for the trajectory's own effort; "true"
            for the plant's own torques, the ideal feedforward.
        parameters, loads, effects, sensors, gears, attached: the arm; see Arm.
        seed: of the noise.
        progress: receives the share done, 0 to 1.

    Raises:
        ArmError: other joints than the arm's; a motion outside its limits or through itself or
            the floor (names joint or links, and time); a feedforward of another shape or not
            finite.
    """
    reference = _on_ticks(trajectory, parameters or ArmParameters(), loads)
    arm = Arm(
        parameters,
        seed=seed,
        loads=loads,
        effects=effects,
        sensors=sensors,
        gears=gears,
        attached=attached,
    )
    with closing(arm):
        torque = _torque(feedforward, trajectory, reference, arm)
        return _drive(arm, reference, torque, progress)


def _on_ticks(trajectory: Trajectory, parameters: ArmParameters, loads: Loads) -> Trajectory:
    unknown = [name for name in trajectory.joints if name not in JOINTS]
    if unknown:
        raise ArmError(
            f"trajectory: the arm has no joint {', '.join(unknown)}; it has {', '.join(JOINTS)}"
        )
    trajectory = trajectory.select(JOINTS)
    count = int(np.floor(trajectory.duration * parameters.sample_rate + 1e-9)) + 1
    time: Floats = np.arange(count, dtype=np.float64) * parameters.tick
    q, qd, qdd = trajectory.sample(trajectory.time[0] + time)
    reference = Trajectory(time, q, qd, qdd, JOINTS)
    check_limits(reference)
    check_clearance(reference, loads)
    return reference


def _torque(
    feedforward: Feedforward, trajectory: Trajectory, reference: Trajectory, arm: Arm
) -> Floats:
    states = reference.q, reference.qd, reference.qdd
    shape = reference.q.shape
    if feedforward is None:
        return np.zeros(shape)
    if isinstance(feedforward, str):
        if feedforward == "true":
            return arm.plant.true_torque(*states)
        if feedforward == "trajectory":
            return trajectory.select(JOINTS).effort_at(trajectory.time[0] + reference.time)
        raise ArmError(f"feedforward: expected 'true' or 'trajectory', got {feedforward!r}")
    if callable(feedforward):
        torque = np.asarray(feedforward(*states), dtype=np.float64)
        if torque.shape != shape:
            raise ArmError(f"feedforward: the function gave {torque.shape}, expected {shape}")
    else:
        points = np.asarray(feedforward, dtype=np.float64)
        if points.shape != trajectory.q.shape:
            raise ArmError(
                f"feedforward: got shape {points.shape}, expected {trajectory.q.shape}, "
                "one row for each point of the trajectory"
            )
        carrier = replace(trajectory, effort=points)
        torque = carrier.select(JOINTS).effort_at(trajectory.time[0] + reference.time)
    bad = np.argwhere(~np.isfinite(torque))
    if bad.size:
        row, n = bad[0]
        raise ArmError(
            f"feedforward: torque of {JOINTS[n]} at {reference.time[row]:.3f} s is not finite"
        )
    return torque


def _drive(arm: Arm, reference: Trajectory, torque: Floats, progress: Progress) -> Run:
    count = len(reference)
    arm.reset(reference.q[0])
    for _ in range(round(SETTLING * arm.parameters.sample_rate)):
        arm.step(reference.q[0], np.zeros(len(JOINTS)), torque[0])
    shape = reference.q.shape
    measured, motion, torques = np.empty((3, *shape)), np.empty((3, *shape)), np.empty((4, *shape))
    saturated = np.zeros(shape, dtype=bool)
    report = max(1, count // 100)
    for k in range(count):
        motion[:, k] = arm.plant.motion
        sample = arm.step(reference.q[k], reference.qd[k], torque[k])
        measured[:, k] = sample[1:]
        torques[:, k] = arm.torques
        saturated[k] = arm.saturated
        if k % report == 0:
            progress(k / count, "driving the arm")
    progress(1.0, "driving the arm")
    q, qd, effort = measured
    recording = Recording(JOINTS, reference.time, q, qd, effort, source="simulated arm")
    position, encoder, velocity = motion
    motor, lost, added, load = torques
    known = position, encoder, velocity, motor, lost, added, load
    return Run(recording, reference, torque, *known, saturated)
