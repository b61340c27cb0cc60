"""What nature has above zero: dissipation, stiffness, mass and inertia.

An effect says which sums of its parameters these are (`Effect.signs`). In the search their estimate
decides, in a verdict their 90 % interval for the shape that was fitted: where a shape is hardly
known, the interval of the amplitude reaches below zero, although an amplitude of zero explains
nothing with any shape. Friction is judged once more, with all other friction of its joint: an
amplitude over position may have any sign as long as all of it together brakes.
"""

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.search.bayes_factor import BayesFactor
from lagrangian_ff.diagnosis.search.fitted import Fitted
from lagrangian_ff.diagnosis.whitening import Whitened
from lagrangian_ff.effects import Inputs

REACH = 1.645
"""Standard deviations from the middle to the ends of a 90 % interval."""
DRIVES = 0.05
"""Share of the friction's work above which it may not drive the joint."""


def natural(score: BayesFactor, x: Inputs) -> bool:
    """Return whether the estimate of an effect has the signs of nature.

    Args:
        score: of an effect.  x: the samples that it was judged on.
    """
    candidate = score.candidate
    signs = candidate.effect.signs(x, candidate.joint, candidate.shape)
    return all(float(weights @ score.coefficients) > 0.0 for weights in signs.values())


def unnatural(whitened: Whitened, score: BayesFactor) -> str:
    """Return why an effect in the basis of a motion may have a sign against nature; empty if not.

    Args:
        whitened: with all findings in its basis, fitted together.  score: of the effect.
    """
    candidate, fitted = score.candidate, Fitted.of(whitened, score.variance_inflation)
    held = fitted.holding([candidate.term()])
    if candidate.cause != candidate.key:  # what a gear does to another joint has either sign
        return ""
    effect, joint, x = candidate.effect, candidate.joint, whitened.x
    place = next(place for term, place in whitened.basis.slices() if term == candidate.term())
    for number, one in zip(range(place.start, place.stop), effect.parameters, strict=True):
        _, high = _interval(held, np.eye(whitened.basis.size)[number])
        if one.positive and high < 0.0:
            return f"its {one.name}, {one.meaning}, is below zero, as no {effect.name} has it"
    for words, weights in effect.signs(x, joint, candidate.shape).items():
        whole = np.zeros(whitened.basis.size)
        whole[place] = weights
        low, high = _interval(held, whole)
        if low <= 0.0:
            return (
                f"{words} is between {low:.3g} and {high:.3g}, not surely above zero as "
                f"{effect.name} has it"
            )
    return _driving(fitted, joint) if effect.part == "friction" else ""


def _interval(fitted: Fitted, weights: Floats) -> tuple[float, float]:
    """Return the 90 % interval of a sum of parameters, for weights of the first columns."""
    low, high = _intervals(fitted, weights[None])
    return float(low[0]), float(high[0])


def _intervals(fitted: Fitted, weights: Floats) -> tuple[Floats, Floats]:
    few = weights.shape[1]
    middle = weights @ fitted.values[:few]
    variance = np.einsum("kb,kb->k", weights @ fitted.covariance[:few, :few], weights)
    reach = REACH * np.sqrt(np.maximum(variance, 0.0))
    return np.asarray(middle - reach), np.asarray(middle + reach)


def _driving(fitted: Fitted, joint: int) -> str:
    """Return where all friction of a joint together drives it; empty if it surely brakes."""
    x, basis = fitted.whitened.x, fitted.whitened.basis
    power = np.zeros((len(x), len(fitted.values)))
    remembers = False
    for term, place in basis.slices():
        if term.joint == joint and term.effect.part == "friction":
            speed = term.effect.speed(x, joint, term.shape)
            power[:, place] = term.columns(x) * speed[:, None]
            remembers |= term.effect.remembers
    for n, term, column in fitted.errors_of_shapes(x, joint):
        if term.effect.part == "friction":
            power[:, n] = column * term.effect.speed(x, joint, term.shape)
    # A curve over speed takes over friction that has a name: only together are they known.
    whole = power.mean(axis=0)
    for n, column in fitted.curves(joint):
        whole[n] = np.mean(column * x.qd[:, joint])
    low, high = _interval(fitted, whole)
    if low <= 0.0:
        return (
            f"all friction of the joint takes between {low:.3g} and {high:.3g} W out of the "
            "motion, not surely more than nothing as friction does"
        )
    if remembers:  # what bends before it slides gives a part back
        return ""
    values = power @ fitted.values
    _, highest = _intervals(fitted, power)
    driven = float(-np.sum(values[highest < 0.0]) / np.sum(np.abs(values)))
    if driven <= DRIVES:
        return ""
    return (
        f"with it, friction would drive the joint in a part of the motion, by {driven:.0%} of "
        "its work, where friction only brakes"
    )
