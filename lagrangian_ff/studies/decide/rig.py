"""The simulated arm, with nuisances and a hidden effect, as an investigation moves it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lagrangian_ff.arm import HOME, JOINTS, Run, Trajectory, limits, reported, simulate
from lagrangian_ff.arm.body import Surroundings
from lagrangian_ff.arm.hidden import Installed, Reference, Site, beyond_friction, size, sized
from lagrangian_ff.arm.hidden.base import together
from lagrangian_ff.arrays import Flags, Floats
from lagrangian_ff.diagnosis.excite import Limits
from lagrangian_ff.diagnosis.excite import Reference as Path
from lagrangian_ff.errors import ArmError
from lagrangian_ff.identification import Model
from lagrangian_ff.investigation import StoppedError
from lagrangian_ff.progress import Progress
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.studies.hidden.cases import Hidden
from lagrangian_ff.studies.nuisances.drawn import Nuisances

PACE = 0.5
"""Share of the arm's highest speeds that motions may take."""
UNTIL_FAST = 0.4
"""s in which a joint may reach that speed."""
MARGIN = 0.02
"""m that the links keep from each other and the floor."""
EVERY = 5
"""Points of a path, every fifth of which is looked at for contact."""
TORQUE = 0.85
"""Share of the motors' torque that a motion may take."""
SLACK = 1e-6


def arm_limits() -> Limits:
    """Return what a careful user allows the simulated arm."""
    arm = limits()
    fastest = PACE * arm.velocity
    whole = Limits(arm.lower, arm.upper, fastest, fastest / UNTIL_FAST, tau_max=TORQUE * arm.effort)
    return Limits.within(whole, JOINTS)


class Clearance:
    """Whether a path of the arm touches anything."""

    def __init__(self) -> None:
        self._around = Surroundings(margin=MARGIN)

    def __call__(self, q: Floats) -> str:
        """Return what touches on a path (M, N) rad, in words; empty if nothing does."""
        for pose in q[::EVERY]:
            if (contact := self._around.first_contact(pose)) is not None:
                return contact
        return ""


class Done(NamedTuple):
    """A motion that the arm did.

    Attributes:
        recording: the driver's report.
        elapsed: (M,) s.  truth: (M, N) N·m of the hidden effect's torque, zeros for none.
    """

    recording: Recording
    elapsed: Floats
    truth: Floats

    def truth_of(self, motion: Motion) -> Motion:
        """Return the conditioned recording with the hidden effect's torque as its own."""
        at = motion.time - self.recording.time[0]
        tau = [np.interp(at, self.elapsed, one) for one in self.truth.T]
        return replace(motion, tau=np.stack(tau, axis=1))


class SimulatedRig:
    """An arm with nuisances and perhaps a hidden effect, that does what it is asked.

    Args:
        nuisances: of its gears and its driver.
        hidden: the effect; None for none.
        seed: of the noise and of the effect's random numbers.
        allowed: limits that it counts motions against.

    Attributes:
        joints: of the arm.
        left: the number of samples in which a motion left its limits or the motors saturated.
        size: RMS of the hidden effect's torque over that of its joint, as far as it can be had; 0
            before `size_along`.
        visible: N·m rms of the effect's torque that plain friction cannot imitate; 0 before that.
        done: what it did so far.
    """

    def __init__(
        self, nuisances: Nuisances, hidden: Hidden | None, seed: int, allowed: Limits
    ) -> None:
        self.joints = JOINTS
        self.left = 0
        self.size = self.visible = 0.0
        self.done: list[Done] = []
        self._nuisances, self._seed, self._allowed = nuisances, seed, allowed
        self._count = 0
        self._everywhere = nuisances.installed([])
        self._hidden = hidden
        self._strength: float | None = None
        self._along: Reference | None = None

    def size_along(self, motion: Trajectory) -> None:
        """Give the hidden effect its size along a motion of the arm without it."""
        run = simulate(motion, parameters=self._nuisances.parameters, **together(self._everywhere))
        self._along = Reference.of(run)
        if self._hidden is not None:
            kind, site = self._hidden.kind, self._site(0)
            installed, self._strength = sized(kind, site, self._hidden.size)
            self.size = size(kind, installed, site)
            self.visible = beyond_friction(kind, installed, site)

    def pose(self) -> Floats:
        """Return (N,) rad, home."""
        return np.array(HOME)

    def run(self, motion: Path, model: Model | None, progress: Progress) -> Recording:
        """Do a motion and return the driver's report of it.

        Raises:
            StoppedError: the arm would touch itself or the floor.
        """
        return self.follow(Trajectory(motion.time, motion.q, motion.qd, motion.qdd, JOINTS))

    def follow(self, trajectory: Trajectory) -> Recording:
        """Do a trajectory and return the driver's report of it.

        Raises:
            StoppedError: the arm would touch itself or the floor.
        """
        parameters = self._nuisances.parameters
        parts = [*self._everywhere, *self._parts()]
        try:
            run = simulate(
                trajectory, parameters=parameters, **together(parts), seed=self._seed + self._count
            )
        except ArmError as error:
            raise StoppedError(str(error)) from error
        truth = self._truth(run)
        self._count += 1
        self.left += int(np.sum(_outside(run.reference, self._allowed) | run.saturated))
        recording = reported(run, self._nuisances.driver, parameters, self._seed + self._count)
        recording = replace(recording, source=f"motion {self._count}")
        self.done.append(Done(recording, run.recording.time - run.recording.time[0], truth))
        return recording

    def _truth(self, run: Run) -> Floats:
        """Return (M, N) N·m of the hidden effect's torque in a run."""
        if self._hidden is None:
            return np.zeros_like(run.position)
        (installed,) = self._parts()
        site = replace(self._site(self._count), along=Reference.of(run))
        return self._hidden.kind.torque(installed, site)

    def _parts(self) -> Sequence[Installed]:
        if self._hidden is None:
            return ()
        if self._strength is None:
            raise ArmError("the hidden effect has no size yet: call size_along first")
        return (self._hidden.kind.install(self._site(self._count), self._strength),)

    def _site(self, recording: int) -> Site:
        assert self._hidden is not None
        assert self._along is not None
        joint = JOINTS.index(self._hidden.joint)
        return Site(joint, self._seed + 7919, recording, self._along, self._nuisances.parameters)


def _outside(motion: Trajectory, allowed: Limits) -> Flags:
    """Return (M, N) whether a motion is outside of what is allowed."""
    q, qd, qdd = motion.q, motion.qd, motion.qdd
    outside = (q < allowed.q_low - SLACK) | (q > allowed.q_high + SLACK)
    outside |= np.abs(qd) > allowed.qd_max * (1.0 + SLACK)
    return np.asarray(outside | (np.abs(qdd) > allowed.qdd_max * (1.0 + 1e-3)))
