"""What a tick of the simulated arm costs: it must keep up with 500 Hz in real time.

    python benchmark/arm_step.py [seconds]

Prints processor and wall time per tick and the real-time ratio (above 1: faster than time).
"""

import sys
import time

import numpy as np

from lagrangian_ff.arm import Arm, exciting_trajectory

SLICE = 250  # ticks


def main() -> None:
    """Drive the arm along an exciting trajectory and time it, slice by slice."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 10.0
    arm = Arm()
    tick = arm.parameters.tick
    q, qd, qdd = exciting_trajectory(8).sample(np.arange(round(seconds / tick)) * tick)
    torque = arm.plant.true_torque(q, qd, qdd)
    arm.reset(q[0])
    wall, cpu = [], []
    for first in range(0, len(q) - SLICE + 1, SLICE):
        wall.append(-time.perf_counter())
        cpu.append(-time.process_time())
        for k in range(first, first + SLICE):
            arm.step(q[k], qd[k], torque[k])
        wall[-1] += time.perf_counter()
        cpu[-1] += time.process_time()
    arm.close()
    for name, spent in (("wall", wall), ("processor", cpu)):
        ms = 1e3 * np.array(spent) / SLICE
        print(
            f"{name:9s} per tick: best {ms.min():.3f} ms, median {np.median(ms):.3f} ms, "
            f"worst {ms.max():.3f} ms (means of {SLICE} ticks)"
        )
    print(f"real-time ratio: {tick * len(wall) * SLICE / sum(wall):.1f}")


if __name__ == "__main__":
    main()
