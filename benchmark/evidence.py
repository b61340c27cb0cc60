"""The gradient of the log evidence over all hyperparameters of `chain`, against one fit.

500 samples of 6 joints, hyperparameters given: the ratio of value, gradient and average information
by all 36 numbers of the kernel, the noise and the friction's shapes, to one fit; bound: 6. What it
must do at least: invert the factor, which costs twice what factoring does, and the derivatives of
the Gram matrix by 36 numbers.
"""

import argparse

from timing import medians, states

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.choosing.evidence import derivatives
from lagrangian_ff.identification.problem import Problem, Scaling
from lagrangian_ff.identification.samples import Samples
from lagrangian_ff.identification.solving.posterior import Posterior, exact
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.identification.spec import parse

BOUND = 6.0


def main() -> None:
    """Measure both in turn, and print medians and their ratio."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=500)
    parser.add_argument("--joints", type=int, default=6)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    x, tau = states(options.samples, options.joints)
    spec, scaling = parse("chain+fri"), Scaling.of(tau, per_joint=False)
    problem = Problem.started(spec, Samples(Inputs.of(x), tau), scaling)

    def fitted() -> Posterior[System]:
        return exact(problem)

    def gradient() -> None:
        derivatives(fitted())

    one, all_ = medians([fitted, gradient], options.repeats)
    print(f"fit {one:.3f} s, with gradient {all_:.3f} s, ratio {all_ / one:.2f} (bound {BOUND:g})")


if __name__ == "__main__":
    main()
