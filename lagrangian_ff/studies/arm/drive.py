"""The arm along one trajectory, recorded once however many models are learned from it."""

import uuid
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arm import PAPER_LOADS, Trajectory, exciting_trajectory, simulate
from lagrangian_ff.arm.exciting import SPEEDS
from lagrangian_ff.arm.simulation import Feedforward
from lagrangian_ff.recording import condition, load, write_npz
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.studies.arm.plan import Plan
from lagrangian_ff.studies.common.study import Request

Floats = NDArray[np.float64]

LOADS = PAPER_LOADS
"""Steel balls of 2.5 kg on link 1, behind the column, and of 1 kg on link 2, beside the elbow:
their centres lie at `lagrangian_ff.arm.description.LOAD_POINTS` of the links' frames."""
HELD = 2 * len(SPEEDS)
"""Trajectories and recordings that a process keeps: all of one study, 4 MB each."""


@dataclass(frozen=True)
class Drive:
    """One trajectory, and the arm that makes it.

    Loaded or not, the arm makes the same motion with the same noise in its sensors.

    Attributes:
        speed: of the exciting trajectory.
        seed: of the motion and of the noise.
        seconds: its length; None is 30 to 40 s.
        loaded: whether the arm carries `LOADS`.
        kept: the folder where the recording with the servo alone is kept; None keeps none.
    """

    speed: int
    seed: int
    seconds: float | None
    loaded: bool = False
    kept: Path | None = None

    @property
    def name(self) -> str:
        """As in `speed04` and `loaded04`."""
        return f"{'loaded' if self.loaded else 'speed'}{self.speed:02d}"

    @property
    def trajectory(self) -> Trajectory:
        """The reference."""
        return _trajectory(self.speed, self.seed, self.seconds)

    @property
    def recording(self) -> Recording:
        """With the servo alone."""
        return _recording(self)

    def motion(self) -> Motion:
        """The recording made ready as for any user."""
        return condition(self.recording)

    def run(self, feedforward: Feedforward = None) -> Recording:
        """Drive the arm along it; see `simulate` for what is fed forward."""
        loads = LOADS if self.loaded else None
        noise = self.seed * (SPEEDS[-1] + 1) + self.speed
        return simulate(self.trajectory, feedforward, loads=loads, seed=noise).recording

    def tracking_error(self, run: Recording) -> Floats:
        """(M, 6) rad, reference less measured position."""
        start = self.trajectory.time[0] - run.time[0]
        return np.asarray(self.trajectory.sample(run.time + start)[0] - run.position)


def drives(plan: Plan, request: Request, folder: Path, *, loaded: bool = False) -> list[Drive]:
    """Along all trajectories of a study, rising in speed.

    Args:
        plan: which.
        request: `seed`, and whether to `keep` recordings.
        folder: of the study, where they are kept.
        loaded: whether the arm carries `LOADS`.
    """
    kept = folder / "recordings" if request.keep else None
    return [Drive(speed, request.seed, plan.seconds, loaded, kept) for speed in plan.speeds]


def mean_speed(motion: Motion) -> float:
    """rad/s, mean over time of the norm of all joints' velocities."""
    return float(np.linalg.norm(motion.qd, axis=1).mean())


@lru_cache(maxsize=HELD)
def _trajectory(speed: int, seed: int, seconds: float | None) -> Trajectory:
    return exciting_trajectory(speed, seed, seconds)


@lru_cache(maxsize=HELD)
def _recording(drive: Drive) -> Recording:
    if drive.kept is None:
        return drive.run()
    path = drive.kept / f"{drive.name}.npz"
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        # Several processes may make it at once: each whole, the last one stays.
        part = path.with_name(f"{drive.name}.{uuid.uuid4().hex}.npz")
        write_npz(part, drive.run()).replace(path)
    return load(path)
