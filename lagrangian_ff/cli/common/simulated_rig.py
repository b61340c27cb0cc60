"""The simulated arm, with what a user hides in it, as an investigation moves it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lagrangian_ff.arm import HOME, JOINTS, Trajectory, limits, simulate
from lagrangian_ff.arm.hiding import Wanted, hidden, usual_motion
from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.excite import Limits, Reference
from lagrangian_ff.errors import ArmError
from lagrangian_ff.identification import Model
from lagrangian_ff.investigation import StoppedError
from lagrangian_ff.investigation.allowed import careful
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording import Recording

if TYPE_CHECKING:
    from lagrangian_ff.arm.hidden.base import Reference as Along


def simulated_limits(speed: float, until_fast: float) -> Limits:
    """Return what a careful user allows the simulated arm; see `allowed`."""
    arm = limits()
    endless = np.full(len(JOINTS), np.inf)
    whole = Limits(arm.lower, arm.upper, arm.velocity, endless, tau_max=arm.effort)
    return careful(whole, JOINTS, speed, until_fast)


class SimulatedRig:
    """The simulated arm, which does what it is asked, faster than real time.

    Args:
        asked: the effects to hide.
        seed: of the noise; every motion has its own.

    Attributes:
        joints: of the arm.
    """

    def __init__(self, asked: Sequence[Wanted], seed: int = 0) -> None:
        self.joints = JOINTS
        self._asked, self._seed, self._count = asked, seed, 0
        self._along: Along | None = None

    def pose(self) -> Floats:
        """Return (N,) rad, home."""
        return np.array(HOME)

    def run(self, motion: Reference, model: Model | None, progress: Progress = silent) -> Recording:
        """Do a motion and return what the driver reports of it.

        Raises:
            StoppedError: the arm would touch itself or the floor.
        """
        if self._asked and self._along is None:
            self._along = usual_motion()
        number = self._seed + self._count
        self._count += 1
        inside = hidden(self._asked, number, along=self._along)
        try:
            done = simulate(
                Trajectory(*motion, JOINTS), **inside.arm, seed=number, progress=progress
            )
        except ArmError as error:
            raise StoppedError(str(error)) from error
        return replace(done.recording, source=f"motion {self._count}")
