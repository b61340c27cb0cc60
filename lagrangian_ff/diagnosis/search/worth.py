"""What a candidate is worth: the evidence with it over the best that there is without it.

Both sides get the prior that suits them. What is missing counts as noise until it is taken in, and
what is not there may take the place of something that the prior was good at: against a prior that
was chosen for the candidate, either would seem to gain much more than it does.
"""

import numpy as np

from lagrangian_ff.diagnosis.ground import Ground, Prior
from lagrangian_ff.diagnosis.ground.ground import Extra
from lagrangian_ff.diagnosis.search.gain import Score, expected


def evidence_without(ground: Ground, chosen: Prior) -> float:
    """Return the log evidence with the prior as it is or chosen anew, whichever suits better."""
    return max(ground.system.log_evidence, ground.relaid(chosen).system.log_evidence)


def worth_of(score: Score, ground: Ground, without: float) -> float:
    """Nats that a candidate gains, tempered as its score is.

    Args:
        score: of the candidate on the ground.
        ground: with the prior that suits the candidate, but without it.
        without: log evidence, the best that is reached without it.
    """
    joint, columns = score.candidate.joint, score.candidate.columns(ground.seen)
    scale = expected(columns, float(ground.spread[joint]))
    # In parts of what is expected a priori, so that parameters of any unit stand beside each other.
    scaled = (columns * scale)[:, scale > 0.0]
    system = ground.relaid(extra=(Extra(joint, scaled), *ground.extra)).system
    own = slice(ground.basis.size, ground.basis.size + scaled.shape[1])
    # The restricted evidence is that of any size: times the prior's density about the one found.
    covariance = np.eye(scaled.shape[1]) + system.amplitude * system.covariance[own, own]
    found = system.coefficients[own]
    squares = found @ np.linalg.solve(covariance, found)
    spread = np.linalg.slogdet(2.0 * np.pi * covariance)[1]
    density = -0.5 * float(squares + spread)
    return (system.log_evidence + density - without) / score.inflation
