"""Prediction: many states against forming the kernel's blocks and multiplying, and one at a time.

For `vrbfs` and `chain`, learned from 500 samples of 6 joints. Prints the ratio of predicting 15,000
states to forming their N × N blocks with the same kernel and multiplying them with the
coefficients, in one run; bound: 1/20. And the median time of one state as a control loop asks for
it, kernel and friction; bounds: 50 and 150 µs.
"""

import argparse
import time

import numpy as np
from timing import medians, states

from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.identification.pointwise import Pointwise
from lagrangian_ff.kernels import KERNELS, CoupledKernel
from lagrangian_ff.recording.motion import Motion

BOUND = 1.0 / 20.0
ONE_STATE = {"vrbfs": 50.0, "chain": 150.0}  # µs
ROWS = 500


def main() -> None:
    """Measure each kernel."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=500)
    parser.add_argument("--joints", type=int, default=6)
    parser.add_argument("--states", type=int, default=15_000)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    u, tau = states(options.samples, options.joints)
    x, _ = states(options.states, options.joints, seed=1)
    for name, bound in ONE_STATE.items():
        kernel = KERNELS[name].start(u)
        assert isinstance(kernel, CoupledKernel)
        learned = kernel.learned(u, tau)

        def blocks(kernel: CoupledKernel = kernel) -> None:
            for first in range(0, len(x), ROWS):
                kernel.cross(x.take(slice(first, first + ROWS)), u) @ tau.ravel()

        def predicted(learned=learned) -> object:  # type: ignore[no-untyped-def]
            return learned.torque(x)

        ours, formed = medians([predicted, blocks], options.repeats)
        print(
            f"{name}: {len(x)} states {ours:.3f} s, blocks formed and multiplied {formed:.3f} s, "
            f"ratio 1/{formed / ours:.1f} (bound 1/{1 / BOUND:g})"
        )
        microseconds = 1e6 * one_state(name, options.joints, options.samples)
        print(f"{name}+fri: one state {microseconds:.1f} µs (bound {bound:g})")


def one_state(name: str, joints: int, samples: int, calls: int = 3000) -> float:
    """Median seconds for the torque of one state, kernel and friction."""
    x, tau = states(10 * samples, joints)
    time_ = np.linspace(0.0, 0.01 * len(x), len(x))
    names = tuple(f"joint_{n + 1}" for n in range(joints))
    segment = np.zeros(len(x), dtype=np.int64)
    motion = Motion(names, time_, x.q, x.qd, x.qdd, tau, segment, "benchmark")
    settings = Settings(model=f"{name}+fri", train=1.0, samples=samples, evaluations=1)
    model = Pointwise(identify(motion, settings).model)
    spent = []
    for call in range(calls):
        row = call % len(x)
        began = time.perf_counter()
        model.torque(x.q[row], x.qd[row], x.qdd[row])
        spent.append(time.perf_counter() - began)
    return float(np.median(spent))


if __name__ == "__main__":
    main()
