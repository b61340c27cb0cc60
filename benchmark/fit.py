"""Fit of `vrbfs+fri` on 500 samples of 6 joints, hyperparameters given, against its Cholesky.

Prints the ratio of a whole fit (Gram matrix, basis, factor, coefficients) to the bare factorisation
of the same 3000 × 3000 matrix with LAPACK's dpotrf, in one run; bound: 1.3.
"""

import argparse
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack
from timing import seconds, states

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.problem import Problem, Scaling
from lagrangian_ff.identification.samples import Samples
from lagrangian_ff.identification.solving.posterior import exact
from lagrangian_ff.identification.spec import parse
from lagrangian_ff.kernels import CoupledKernel

Floats = NDArray[np.float64]

BOUND = 1.3


def main() -> None:
    """Measure both in turn, and print medians and their ratio."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=500)
    parser.add_argument("--joints", type=int, default=6)
    parser.add_argument("--repeats", type=int, default=9)
    options = parser.parse_args()
    x, tau = states(options.samples, options.joints)
    spec = parse("vrbfs+fri")
    problem = Problem.started(spec, Samples(Inputs.of(x), tau), Scaling.of(tau))
    kernel = problem.kernel
    assert isinstance(kernel, CoupledKernel)
    gram = kernel.gram(x)
    size = gram.shape[0]
    gram[np.triu_indices(size, 1)] = gram.T[np.triu_indices(size, 1)]
    gram.flat[:: size + 1] += np.tile(problem.noise, len(x))

    def whole() -> None:
        model = exact(problem)
        assert np.isfinite(model.weights).all()
        assert np.isfinite(model.coefficients).all()

    def bare(matrix: Floats) -> None:
        _, info = lapack.dpotrf(matrix.T, lower=0, clean=0, overwrite_a=1)
        assert info == 0

    times = []
    for run in range(options.repeats + 1):
        matrix = gram.copy()
        pair = seconds(whole), seconds(partial(bare, matrix))
        if run > 0:  # the first one compiles
            times.append(pair)
    fits, factors = np.median(times, axis=0)
    ratio = float(np.median([a / b for a, b in times]))
    print(f"{options.samples} samples x {options.joints} joints, median of {options.repeats} runs")
    print(f"fit                  {1e3 * fits:8.1f} ms")
    print(f"Cholesky (dpotrf)    {1e3 * factors:8.1f} ms")
    print(f"fit / Cholesky       {ratio:8.2f}    (bound {BOUND:g})")


if __name__ == "__main__":
    main()
