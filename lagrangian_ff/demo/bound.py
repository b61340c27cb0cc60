"""The bound: how well the arm tracks when it is fed with its own true torques.

It needs no ROS, so it is simulated in a process of its own while the arm moves.
"""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.pool import AsyncResult
from typing import TYPE_CHECKING

from lagrangian_ff.report import Tracking

if TYPE_CHECKING:
    from lagrangian_ff.arm import Trajectory


@contextmanager
def bound_of(
    trajectories: "list[Trajectory]", seed: int
) -> Iterator["AsyncResult[list[Tracking]]"]:
    """Begin to track the trajectories; leaving the context ends it.

    Args:
        trajectories: where the arm should be.
        seed: of the sensors' noise.
    """
    # A fork would take ROS's threads with it.
    with get_context("spawn").Pool(1, _leave_the_terminal) as pool:
        yield pool.starmap_async(track, [(trajectory, seed) for trajectory in trajectories])


def track(trajectory: "Trajectory", seed: int) -> Tracking:
    """The tracking error of the arm fed with its true torques."""
    from lagrangian_ff.arm import simulate  # PyBullet, which talks when it is imported

    run = simulate(trajectory, "true", seed=seed)
    return Tracking("bound", run.recording.joints, run.reference.time, run.tracking_error)


def _leave_the_terminal() -> None:
    """Leave Ctrl-C to the process that started this one, and say nothing, as PyBullet would."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
