"""The bound: tracking of the arm that is fed with its own true torques.

It needs no ROS; a separate process simulates it while the arm moves.
"""

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import TimeoutError, get_context
from typing import TYPE_CHECKING

from lagrangian_ff.errors import DemoError
from lagrangian_ff.report import Tracking

if TYPE_CHECKING:
    from lagrangian_ff.arm import Trajectory

PATIENCE = 300.0  # s


@contextmanager
def bound_of(trajectories: "list[Trajectory]", seed: int) -> Iterator[Callable[[], list[Tracking]]]:
    """Start to track the trajectories; yield a function that waits for the errors.

    Leaving the context ends it. The seed is that of the sensors' noise.
    """
    # A fork would take ROS's threads with it.
    with get_context("spawn").Pool(1, _leave_the_terminal) as pool:
        pending = pool.starmap_async(track, [(trajectory, seed) for trajectory in trajectories])

        def found() -> list[Tracking]:
            try:
                return pending.get(PATIENCE)
            except TimeoutError:
                raise DemoError("the bound was not simulated; is there memory left?") from None

        yield found


def track(trajectory: "Trajectory", seed: int) -> Tracking:
    """Return the tracking error of the arm fed with its true torques."""
    from lagrangian_ff.arm import simulate  # PyBullet, which prints when it is imported

    run = simulate(trajectory, "true", seed=seed)
    return Tracking("bound", run.recording.joints, run.reference.time, run.tracking_error)


def _leave_the_terminal() -> None:
    """Leave Ctrl-C to the parent process, and discard what PyBullet prints."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
