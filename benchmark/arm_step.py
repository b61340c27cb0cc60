"""What a tick of the simulated arm costs, against PyBullet's calls alone in the same run.

    python benchmark/arm_step.py [seconds]

Prints processor time per tick of 2 ms, how many times as fast as time that is, and what it is over
the bare calls of PyBullet: those that the arm makes, and those of PyBullet's own stepping.
"""

import sys
import time
from collections.abc import Callable

import numpy as np

from lagrangian_ff.arm import Arm, exciting_trajectory
from lagrangian_ff.arm.body import Body

SLICE = 250  # ticks
STILL = np.zeros(6)


def main() -> None:
    """Drive the arm along an exciting trajectory and time it, slice by slice."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 10.0
    arm, body = Arm(), Body()
    tick, substeps = arm.parameters.tick, round(arm.parameters.tick / arm.plant.dt)
    q, qd, qdd = exciting_trajectory(8).sample(np.arange(round(seconds / tick)) * tick)
    torque = arm.plant.true_torque(q, qd, qdd)
    arm.reset(q[0])
    positions, velocities = q.tolist(), qd.tolist()

    def step(k: int) -> None:
        arm.step(q[k], qd[k], torque[k])

    def dynamics(k: int) -> None:
        for _ in range(substeps):
            body.dynamics(positions[k], velocities[k])

    def stepping(k: int) -> None:
        for _ in range(substeps):
            body.advance(STILL)
            body.state()

    work = {"the arm": step, "mass matrix and bias": dynamics, "PyBullet's stepping": stepping}
    spent: dict[str, list[float]] = {name: [] for name in work}
    for first in range(0, len(q) - SLICE + 1, SLICE):
        for name, one in work.items():
            spent[name].append(_seconds(one, first))
    arm.close()
    body.close()
    median = {name: float(np.median(times)) / SLICE for name, times in spent.items()}
    for name, each in median.items():
        print(
            f"{name:20s} {1e6 * each:6.1f} µs of processor a tick (best "
            f"{1e6 * min(spent[name]) / SLICE:.1f}), {tick / each:6.1f} x as fast as time"
        )
    whole = median["the arm"]
    bare = median["mass matrix and bias"]
    print(f"the arm over the calls of PyBullet that it makes: {whole / bare:.1f}")
    both = bare + median["PyBullet's stepping"]
    print(f"the arm over these and PyBullet's own stepping: {whole / both:.2f}")


def _seconds(work: Callable[[int], None], first: int) -> float:
    began = time.process_time()
    for k in range(first, first + SLICE):
        work(k)
    return time.process_time() - began


if __name__ == "__main__":
    main()
