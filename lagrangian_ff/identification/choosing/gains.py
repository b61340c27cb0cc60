"""Units of effort that differ between joints, found by the evidence: the gains of their drives.

The torques of an arm derive from one Lagrangian in the right units only. Where a driver multiplies
the current of each motor by a wrong constant, one unit for all is wrong, and a unit of each joint's
own spread is so, too.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from lagrangian_ff.arrays import Floats
from lagrangian_ff.identification.problem import Problem, Scaling
from lagrangian_ff.identification.solving.posterior import exact

ROUNDS = 3
FIRST_STEP, SHORTER = 0.25, 0.4
"""Step of the logarithm of a gain, and the factor on it where no step helps."""


@dataclass(frozen=True)
class Gains:
    """The likeliest units of effort.

    Attributes:
        unit: (N,) N·m that count as one; that of the first joint is as it was.
        nats: log evidence gained.
    """

    unit: Floats
    nats: float

    def of(self, problem: Problem) -> Problem:
        """Return the problem in these units, with the same noise in them."""
        scaling = Scaling(self.unit, problem.prior.scaling.spread / self.unit)
        return problem.having(
            scaling=scaling, noise=problem.noise * (self.unit / problem.unit) ** 2
        )


def gains_of(problem: Problem, unit: Floats) -> Gains:
    """Return given units of effort with the evidence for them.

    Args:
        unit: (N,) N·m; only their ratios count.

    Raises:
        NotPositiveDefiniteError: the Gram matrix is not positive definite.
    """
    evidence = _by_gain(problem)
    gain = unit / unit[0]
    return Gains(problem.unit[0] * gain, evidence(gain) - evidence(problem.unit / problem.unit[0]))


def likeliest_gains(problem: Problem) -> Gains:
    """Return the units of effort that the evidence is largest in, by steps of joint after joint.

    Raises:
        NotPositiveDefiniteError: the Gram matrix is not positive definite.
    """
    evidence = _by_gain(problem)
    gain = problem.unit / problem.unit[0]
    first = best = evidence(gain)
    steps = np.full(len(gain), FIRST_STEP)
    for _ in range(ROUNDS):
        for joint in range(1, len(gain)):
            for sign in (1.0, -1.0):
                tried = gain.copy()
                tried[joint] *= np.exp(sign * steps[joint])
                value = evidence(tried)
                if value > best:
                    best, gain = value, tried
                    break
            else:
                steps[joint] *= SHORTER
    return Gains(problem.unit[0] * gain, best - first)


def _by_gain(problem: Problem) -> Callable[[Floats], float]:
    """Return the log evidence in N·m as a function of the units (N,) relative to the first joint's.

    The units change no Gram matrix.
    """
    system = exact(problem).system
    joints = len(problem.unit)
    apart = (system.target.reshape(-1, joints, 1) * np.eye(joints)).reshape(-1, joints)
    white = solve_triangular(system.upper, apart, trans=1, check_finite=False)

    def evidence(gain: Floats) -> float:
        unit = problem.unit[0] * gain
        scale = problem.unit / unit
        design = system.white_design * scale[problem.basis.joints]
        scaled = replace(system, white_design=design, white_target=white @ scale)
        return scaled.log_evidence - len(problem.samples) * float(np.sum(np.log(unit)))

    return evidence
