"""The gradient of the log evidence over all hyperparameters of `chain`, against one fit.

500 samples of 6 joints, hyperparameters given: the ratio of value, gradient and average information
by all 36 numbers of the kernel, the noise and the friction's shapes, to one fit; bound: 6. What it
must do at least: invert the factor, which costs twice what factoring does, and the derivatives of
the Gram matrix by 36 numbers.
"""

import argparse

import numpy as np
from timing import medians, states

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.choice import Scaling
from lagrangian_ff.identification.choosing.evidence import slopes_of
from lagrangian_ff.identification.choosing.search import starting_choice
from lagrangian_ff.identification.choosing.training import TrainingSet
from lagrangian_ff.identification.solving.equations import fit_basis
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
    choice = starting_choice(spec, x)
    inputs = Inputs.of(x)
    basis = choice.basis(spec, options.joints)
    fold = (np.arange(len(x)) * 5) // len(x)
    data = TrainingSet(inputs, tau, fold)

    def fitted():  # type: ignore[no-untyped-def]
        return fit_basis(basis, choice, inputs, tau, scaling)

    def gradient() -> None:
        slopes_of(fitted(), data)

    one, all_ = medians([fitted, gradient], options.repeats)
    print(f"fit {one:.3f} s, with gradient {all_:.3f} s, ratio {all_ / one:.2f} (bound {BOUND:g})")


if __name__ == "__main__":
    main()
