"""A rig of two rods with friction, and perhaps a drag that grows with the square of the speed."""

from dataclasses import dataclass, field

import numpy as np
import pendulum

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.excite import Limits, Reference
from lagrangian_ff.identification import Model
from lagrangian_ff.investigation import Plan, StoppedError
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress
from lagrangian_ff.recording import Recording

START = np.array([0.2, -0.1])
NOISE = 0.02  # N·m
ROUNDING = 1e-6


def limits() -> Limits:
    """Return the limits that motions must not leave."""
    low, high = np.array([-1.2, -1.5]), np.array([1.4, 1.2])
    return Limits(low, high, np.array([2.0, 3.0]), np.array([8.0, 12.0]))


def plan(seconds: float, **more: object) -> Plan:
    """Return a plan of short motions."""
    given = {"first": 12.0, "each": 12.0, "model": "vrbfs+fri", **more}
    return Plan(limits(), budget=seconds, **given)  # type: ignore[arg-type]


@dataclass
class PendulumRig:
    """Does what it is asked.

    Attributes:
        drag: N·m s²/rad² of the elbow.
        rough: N·m of friction that is a wave over the elbow's position, as no known effect is.
        late: s by which torques are reported late.
        last: number of the motion in which it is stopped; 0 for none.
        stuck: number of the motion that it does not do; 0 for none.
        moved: the motions that were done.
    """

    drag: float = 0.0
    rough: float = 0.0
    late: float = 0.0
    last: int = 0
    stuck: int = 0
    joints: tuple[str, ...] = pendulum.JOINTS
    moved: list[Reference] = field(default_factory=list)

    def pose(self) -> Floats:
        return START.copy()

    def run(self, motion: Reference, model: Model | None, progress: Progress) -> Recording:
        """Do a motion, unless it is the last."""
        if len(self.moved) + 1 == self.last:
            raise StoppedError("somebody stopped it")
        self.moved.append(motion)
        if len(self.moved) == self.stuck:
            motion = motion._replace(
                q=0 * motion.q + motion.q[0], qd=0 * motion.qd, qdd=0 * motion.qdd
            )
        x = States.of(motion.q, motion.qd, motion.qdd)
        tau = pendulum.rigid_torque(x) + pendulum.friction_torque(x)
        tau[:, 1] += self.drag * x.qd[:, 1] * np.abs(x.qd[:, 1])
        tau[:, 1] += self.rough * np.tanh(x.qd[:, 1] / 0.02) * np.sin(5.3 * x.q[:, 1])
        random = np.random.default_rng(len(self.moved))
        at = motion.time - self.late
        tau = np.stack([np.interp(at, motion.time, one) for one in tau.T], axis=1)
        tau += NOISE * random.normal(size=tau.shape)
        return Recording(self.joints, motion.time, motion.q, motion.qd, tau)

    @property
    def seconds(self) -> float:
        """Return how long it moved."""
        return sum(float(one.time[-1]) for one in self.moved)

    def left(self, allowed: Limits) -> int:
        """Return in how many samples motions left limits."""
        count = 0
        for one in self.moved:
            out = (one.q < allowed.q_low - ROUNDING) | (one.q > allowed.q_high + ROUNDING)
            out |= np.abs(one.qd) > allowed.qd_max * (1.0 + ROUNDING)
            out |= np.abs(one.qdd) > allowed.qdd_max * (1.0 + 1e-3)
            count += int(out.any(axis=1).sum())
        return count
