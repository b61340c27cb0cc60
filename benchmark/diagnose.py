"""The parts of a diagnosis of 60 s of 6 joints, each against what it cannot do without, in one run.

- Scoring every effect once (columns, whitening, projection, evidence) against SciPy's solve
  of as many columns with the same factor, in single precision; bound: 3.
- The null of the maximum, by random signs of blocks, against the bare products of the signs.
- Blocks left out, and the load predicted without each, against LAPACK's inverse of the factor.

And, for who waits for it, the seconds of a whole diagnosis; what is promised is 15 on two cores.
"""

import argparse

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack, solve_triangular
from timing import moving, seconds

from lagrangian_ff.diagnosis import diagnose
from lagrangian_ff.diagnosis.search.bayes_factor import bayes_factors
from lagrangian_ff.diagnosis.search.candidates import named, nonparametric
from lagrangian_ff.diagnosis.search.significance import DRAWS, MaximumNull
from lagrangian_ff.diagnosis.whitening import fit
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

BOUND = 3.0
PROMISED = 15.0  # s


def motion(seed: int, joints: int, length: float) -> Motion:
    """Joints that feel gravity, inertia and friction, and a ripple on the second that is hidden."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, length, 0.01)
    q, qd, qdd, tau = moving(rng, t, joints)
    tau[:, 1] += 1.2 * np.cos(7.0 * q[:, 1])
    tau += 0.2 * rng.normal(size=tau.shape)
    names = tuple(f"joint_{n + 1}" for n in range(joints))
    return Motion(names, t, q, qd, qdd, tau, np.zeros(len(t), dtype=np.int64), "benchmark")


def main() -> None:
    """Measure both in turn, and print medians and their ratio."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--joints", type=int, default=6)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    first, second = (motion(seed, options.joints, options.seconds) for seed in (1, 2))
    model = identify(first, Settings(train=1.0, samples=200, evaluations=20)).model
    whitened = fit(first, model.inputs_of(first), model.basis)
    joints = range(options.joints)
    candidates = [*named(whitened.x, whitened.basis, joints), *nonparametric(whitened.x, joints)]
    columns = sum(one.columns(whitened.x).shape[1] for one in candidates)
    upper = np.asarray(whitened.system.upper, dtype=np.float32, order="F")
    right = np.ones((upper.shape[0], 256), dtype=np.float32, order="F")

    def look() -> object:
        return bayes_factors(whitened, candidates, coarse=True)

    def bare() -> None:
        for _ in range(-(-columns // 256)):
            solve_triangular(upper, right, trans=1, check_finite=False)

    looks = [(seconds(look), seconds(bare)) for _ in range(options.repeats)]
    ours, bound = np.median(np.array(looks), axis=0)
    print(f"{len(candidates)} candidates, {columns} columns of {upper.shape[0]} torques")
    print(
        f"look {ours:.2f} s, bare solve {bound:.2f} s, ratio {ours / bound:.2f} (bound {BOUND:g})"
    )
    scored = bayes_factors(whitened, candidates, coarse=True)
    blocks = np.hstack([score.blocks for score in scored])
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (DRAWS, len(blocks)))
    pairs = (
        ("null", lambda: MaximumNull.of(scored), "its products", lambda: signs @ blocks),
        (
            "left out",
            whitened.inputs_left_out,
            "inverse",
            lambda: lapack.dtrtri(whitened.system.upper),
        ),
    )
    for name, work, against, least in pairs:
        took = np.array([(seconds(work), seconds(least)) for _ in range(options.repeats)])
        ours, bound = np.median(took, axis=0)
        print(f"{name} {ours:.3f} s, {against} {bound:.3f} s, ratio {ours / bound:.2f}")
    whitened.forget()
    found: list[str] = []

    def whole() -> None:
        findings = diagnose(model, first, second).findings
        found.extend(f"{one.effect.name} on {one.joint}" for one in findings)

    elapsed = seconds(whole)
    print(
        f"whole diagnosis {elapsed:.1f} s (promised: {PROMISED:g} on 2 cores): {', '.join(found)}"
    )


if __name__ == "__main__":
    main()
