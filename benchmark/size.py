"""A fit of `vrbfs+fri` on landmarks for recordings of growing length, hyperparameters given.

Prints, for 6 joints, the processor's time per sample and the peak memory of each length, each in a
separate process, and the ratio of the longest's time per sample to the shortest's; bound: 1.3,
which is to say that time is linear in the samples. And, for who waits for it, what `lagrangian_ff
identify` takes with --bag for a bag of the longest length; promised for 1e6 samples is 2 GB.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from timing import moving

Floats = NDArray[np.float64]

BOUND = 1.3
PROMISED = 2.0  # GB
RATE = 500.0  # Hz
MINUTE = 30_000
LENGTHS = (2_000, 8_000)
FULL = (10_000, 100_000, 1_000_000)


def motion(samples: int, joints: int) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Time, q, qd, qdd and noisy torque of joints that feel gravity, inertia and friction."""
    rng = np.random.default_rng(0)
    t = np.arange(samples) / RATE
    q, qd, qdd, tau = moving(rng, t, joints)
    return t, q, qd, qdd, tau + 0.4 * rng.normal(size=tau.shape)


def fit_one(samples: int, joints: int, landmarks: int) -> float:
    """Return the seconds of a whole fit on these samples, without what is compiled at first."""
    from lagrangian_ff.effects import Inputs
    from lagrangian_ff.identification.problem import Problem, Scaling
    from lagrangian_ff.identification.samples import Samples, evenly
    from lagrangian_ff.identification.solving.posterior import inducing_solver
    from lagrangian_ff.identification.spec import parse
    from lagrangian_ff.kernels import States

    _, q, qd, qdd, tau = motion(samples, joints)
    x = States.of(q, qd, qdd)
    spec = parse("vrbfs+fri")
    # The same for every length, or the longer ones would differ more from each other.
    at = States.of(*motion(MINUTE, joints)[1:4]).take(evenly(MINUTE, landmarks))
    points = Samples(Inputs.of(at), np.zeros_like(at.q))
    problem = Problem.started(spec, points, Scaling.of(tau))

    def fit(count: int) -> float:
        part, groups = x.take(slice(0, count)), np.array_split(np.arange(count), 5)
        began = time.process_time()  # other work on the machine must not count
        samples = Samples(Inputs.of(part), tau[:count])
        found = inducing_solver(problem.of(samples), at, groups)(None)
        assert np.isfinite(found.weights).all()
        assert np.isfinite(found.coefficients).all()
        return time.process_time() - began

    fit(50)
    return fit(samples)


def identify(samples: int, joints: int) -> tuple[float, float]:
    """Seconds and GB at most of the command on a bag."""
    from lagrangian_ff.recording import Recording
    from lagrangian_ff.recording.bag_writer import write_bag

    names = tuple(f"joint_{n + 1}" for n in range(joints))
    with tempfile.TemporaryDirectory() as folder:
        t, q, qd, _, tau = motion(samples, joints)
        bag = write_bag(Path(folder) / "bag", Recording(names, t, q, qd, tau, start=1.7e9))
        command = [sys.executable, "-m", "lagrangian_ff.cli", "identify", str(bag)]
        command += ["--landmarks", "300", "--output", f"{folder}/model.npz"]
        began = time.perf_counter()
        child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        _, status, used = os.wait4(child.pid, 0)
        assert status == 0
        return time.perf_counter() - began, gigabytes(used)


def gigabytes(used: resource.struct_rusage) -> float:
    """The memory that was held at most."""
    return used.ru_maxrss * 1024 / 1e9


def main() -> None:
    """Measure every length in a separate process."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--joints", type=int, default=6)
    parser.add_argument("--landmarks", type=int, default=100)
    parser.add_argument("--lengths", type=int, nargs="+", default=LENGTHS)
    parser.add_argument("--full", action="store_true", help="1e4, 1e5 and 1e6 samples, and a bag")
    parser.add_argument("--bag", action="store_true", help="identify from a bag as well")
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        took = fit_one(options.one, options.joints, options.landmarks)
        print(took, gigabytes(resource.getrusage(resource.RUSAGE_SELF)))
        return
    lengths = FULL if options.full else tuple(options.lengths)
    print(f"{options.joints} joints, {options.landmarks} landmarks")
    each = []
    for samples in lengths:
        command = [sys.executable, __file__, "--one", str(samples)]
        command += ["--joints", str(options.joints), "--landmarks", str(options.landmarks)]
        told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        took, held = map(float, told.split())
        each.append(took / samples)
        print(f"{samples:9d} samples  {1e3 * each[-1]:8.3f} ms a sample  {held:5.2f} GB")
    print(f"longest / shortest a sample  {each[-1] / each[0]:5.2f}    (bound {BOUND:g})")
    if options.full or options.bag:
        took, held = identify(lengths[-1], options.joints)
        print(
            f"identify a bag of {lengths[-1]}: {took:.0f} s, {held:.2f} GB (promised: {PROMISED:g})"
        )


if __name__ == "__main__":
    main()
