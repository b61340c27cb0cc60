"""Fig. 3 of the paper: viscous and Coulomb friction, noise, and kernels with and without `fri`."""

from collections.abc import Mapping, Sequence

import numpy as np

from lagrangian_ff.studies import dof
from lagrangian_ff.studies.robots import Scene
from lagrangian_ff.studies.study import Line

QUICK = ("srbfs", "vrbfs", "chain")
FEW_JOINTS = 2
MANY_TIMES = 3.0
"""A kernel fails where its error is more than this times that of the same with `fri`; with `fri` it
is back where its error is less than this times that where there is no friction."""


def _both(kernels: Sequence[str]) -> tuple[str, ...]:
    return tuple(model for kernel in kernels for model in (kernel, f"{kernel}+fri"))


class FrictionStudy(dof.DofStudy):
    """How does friction spoil a kernel, and does `fri` mend it?"""

    name = "friction"
    robots = 8
    usual = _both((*dof.PAPER, *dof.OURS))
    quick_usual = _both(QUICK)
    scene = Scene(friction=True, noise=0.05)
    quick_scene = Scene(training=100, validation=500, friction=True, noise=0.05)
    gamma = None

    def results(self, lines: Sequence[Line]) -> dof.DofResults:
        """Return the statistics, and whether section IV-A's claims hold, kernel by kernel."""
        errors = dof.errors_of(lines)
        claims = [
            claim
            for model in errors
            if f"{model}+fri" in errors
            for claim in _claims(model, errors[model], errors[f"{model}+fri"])
        ]
        return dof.DofResults.of(lines, claims, by_friction=True)


ByRobot = Mapping[int, dof.RobotError]


def _claims(
    model: str, bare: Mapping[int, ByRobot], knowing: Mapping[int, ByRobot]
) -> list[dof.Comparison]:
    """Compare a kernel with the same and `fri`, over the robots that were learned with both.

    `frictionless` is the error of the latter's numbers where there is no friction.
    """
    means: dict[int, tuple[float, float, float]] = {}
    robots: dict[int, int] = {}
    for joints in sorted(set(bare) & set(knowing)):
        both = sorted(set(bare[joints]) & set(knowing[joints]))
        if both:
            robots[joints] = len(both)
            means[joints] = (
                float(np.mean([bare[joints][robot].error for robot in both])),
                float(np.mean([knowing[joints][robot].error for robot in both])),
                float(np.mean([knowing[joints][robot].frictionless for robot in both])),
            )
    ratio = {joints: without / with_fri for joints, (without, with_fri, _) in means.items()}
    names = model, f"{model}+fri", "frictionless"

    def claim(words: str, holds: Mapping[int, bool]) -> dof.Comparison:
        rows = {
            joints: dof.Compared(held, dict(zip(names, means[joints], strict=True)), robots[joints])
            for joints, held in holds.items()
        }
        return dof.Comparison(words, rows)

    claims = [
        claim(
            f"{model} without fri fails at few joints",
            {joints: ratio[joints] > MANY_TIMES for joints in ratio if joints <= FEW_JOINTS},
        ),
        claim(
            f"{model}+fri errs as where there is no friction",
            {
                joints: with_fri < MANY_TIMES * alone
                for joints, (_, with_fri, alone) in means.items()
            },
        ),
        claim(
            f"{model} misses fri less than at one joint",
            {joints: ratio[joints] < ratio[1] for joints in ratio if joints > 1 and 1 in ratio},
        ),
    ]
    return [each for each in claims if each.joints]
