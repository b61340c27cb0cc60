"""Five-fold blocked cross-validation against one fit: `chain+fri`, 500 samples of 6 joints.

Prints the ratio to one fit of validating one setting of hyperparameters, bound 3, and of validating
ten values of the noise at the same kernel, bound 6. What one must do at least: factor (one fit),
invert the factor (as many operations again), and form and solve the blocks left out, a fifth of the
matrix each (0.7 of a factorisation). The noise stands in the factor, so that ten values need ten
factors: beyond the bound, and docs/speed.md says why no other way is shorter.
"""

import argparse

import numpy as np
from timing import medians, states

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.choosing.left_out import validation_score
from lagrangian_ff.identification.problem import Problem, Scaling
from lagrangian_ff.identification.samples import Samples
from lagrangian_ff.identification.solving.posterior import exact
from lagrangian_ff.identification.spec import parse

ONE, TEN = 3.0, 6.0
FOLDS = 5


def main() -> None:
    """Measure all in turn, and print medians and their ratios."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=500)
    parser.add_argument("--joints", type=int, default=6)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    x, tau = states(options.samples, options.joints)
    spec, scaling = parse("chain+fri"), Scaling.of(tau, per_joint=False)
    problem = Problem.started(spec, Samples(Inputs.of(x), tau), scaling)
    groups = np.array_split(np.arange(len(x)), FOLDS)

    def fitted(factor: float = 1.0) -> object:
        return exact(problem.noisier(factor)).coefficients

    def validated(factor: float = 1.0) -> object:
        return validation_score(exact(problem.noisier(factor)), groups)

    def ten() -> object:
        return [validated(factor) for factor in np.geomspace(0.1, 100.0, 10)]

    fit, one, all_ = medians([fitted, validated, ten], options.repeats)
    print(f"fit {fit:.3f} s, validated {one:.3f} s, ratio {one / fit:.2f} (bound {ONE:g})")
    print(f"ten values of the noise {all_:.3f} s, ratio {all_ / fit:.1f} (bound {TEN:g})")


if __name__ == "__main__":
    main()
