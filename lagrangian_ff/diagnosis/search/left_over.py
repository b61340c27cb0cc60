"""What no effect and no curve explains: a flexible regression of the residual on products.

A torque that the positions of three joints set together shows over no single coordinate, and looks
like noise to the search. Each dependence is a smooth function of up to three quantities of any
joints. They compete as candidates do: by log Bayes factor, against the null of the maximum, and
then, frozen, on motion that was not used to find them.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.search.bayes_factor import (
    BayesFactor,
    bayes_factors,
    expected,
    log_bayes_factor_of,
    tempered_log_bf,
)
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.diagnosis.search.forward import Search
from lagrangian_ff.diagnosis.search.hold_out import HoldOutMotion
from lagrangian_ff.diagnosis.search.judging import Step, explained_with
from lagrangian_ff.diagnosis.search.nonparametric import Sinusoid
from lagrangian_ff.diagnosis.search.products import Product, pool, products_of
from lagrangian_ff.diagnosis.search.significance import MaximumNull
from lagrangian_ff.diagnosis.whitening import Whitened, refit
from lagrangian_ff.kernels import threads

NEAREST = 2
"""Samples, not averaged, over which the noise of two is independent behind a low-pass of 25 Hz."""
ROUNDING = 1e-7
"""Share of a whitened column, in single precision, below which nothing of it remains."""
MOST = 3
"""Dependences looked closer at, at most."""


def with_left_over(
    found: Search, unseen: Callable[[], HoldOutMotion]
) -> tuple[Search, frozenset[int]]:
    """Return a search with a step for each dependence that is left, on unseen motion too.

    Args:
        found: the search, which ended because nothing stood out.
        unseen: returns the hold-out motion with all findings subtracted; called if it is needed.

    Returns:
        The search, and the numbers of the steps without a name that unseen motion has as well.
    """
    if found.wanting:
        return found, frozenset()
    limits = thresholds.USED
    taken: list[Step] = []
    whitened = found.whitened
    other: HoldOutMotion | None = None
    curves = [number for number, step in enumerate(found.steps) if not step.named]
    if curves:
        other = unseen()
    again = {n for n in curves if other is not None and _comes_again(found.steps[n], other)}
    joints = list(range(whitened.joints))
    for _ in range(MOST):
        scores = _scores(whitened, joints)
        null = MaximumNull.of(scores)
        first = max(scores, key=lambda score: score.log_bf, default=None)
        if first is None or first.log_bf <= limits.floor:
            break
        p_value = null.p_value(first.log_bf)
        if p_value > limits.level:
            break
        best, refitted = _refitted(whitened, first)
        joint = best.candidate.joint
        least = limits.least_left * float(whitened.spread[joint])
        holds = best.log_bf > limits.floor and best.size > least
        if holds:
            other = other or unseen()
            holds, less = _held_out(other, best)
            other = less if holds else other
        if not holds:
            joints.remove(joint)
            continue
        taken.append(Step(best, (), first.log_bf, p_value, None))
        whitened = refitted.explaining(*explained_with(refitted, best.candidate))
    again |= {len(found.steps) + n for n in range(len(taken))}
    return replace(found, steps=(*found.steps, *taken), whitened=whitened), frozenset(again)


def _comes_again(step: Step, motion: HoldOutMotion) -> bool:
    """Return whether unseen motion has the curve of a step, with frozen coefficients.

    A tone has another phase there, and is fitted again. A curve over time never comes again:
    noise that changes slowly makes one in every recording.
    """
    candidate, bare = step.score.candidate, motion.alone()
    if isinstance(candidate.source, Sinusoid):
        (score,) = bayes_factors(bare.whitened, [candidate])
        return score.log_bf > thresholds.USED.floor
    return _held_out(bare, step.score)[0]


def more_than_noise(whitened: Whitened) -> Floats:
    """Return (N,) N·m, how far what is left exceeds the noise of the measurement; 0 if it does not.

    The noise is read off from what changes between both halves of the time that each sample is the
    mean of: within some hundredths of a second, missing physics hardly changes.
    """
    limits = thresholds.USED
    error = whitened.motion.tau - whitened.inputs.torque
    half = max(whitened.x.window // 2, 1)
    gap = 1 if whitened.x.window > 1 else NEAREST
    sums = np.concatenate([np.zeros((1, error.shape[1])), np.cumsum(error, axis=0)])
    segment = whitened.motion.segment
    reach = half + gap - 1
    inner = whitened.index[(whitened.index >= reach) & (whitened.index + reach < len(error))]
    inner = inner[segment[inner - reach] == segment[inner + reach]]
    if not len(inner):
        return np.zeros(whitened.joints)
    after = sums[inner + reach + 1] - sums[inner + gap]
    before = sums[inner - gap + 1] - sums[inner - reach]
    halves = 2.0 if whitened.x.window > 1 else 1.0
    noise = np.sqrt(np.mean((after - before) ** 2, axis=0) / (2.0 * halves)) / half
    left = np.sqrt(np.maximum(whitened.noise**2 - noise**2, 0.0))
    slow = whitened.noise > limits.above_noise * noise
    return np.where(slow & (left > limits.least_rest * whitened.spread), left, 0.0)


def torque_of_curves(found: Search, curves: Sequence[Step]) -> Floats:
    """Return (N,) N·m, what curves explain on each joint that nothing else in the model can.

    Most of a curve over a load may be gravity, which is no part of it.

    Args:
        curves: steps of the search without a name.
    """
    whitened, squares = found.whitened, np.zeros(found.whitened.joints)
    for joint in {curve.score.candidate.joint for curve in curves}:
        mine = [curve for curve in curves if curve.score.candidate.joint == joint]
        less = whitened.explaining(whitened.basis, found.without_curves(mine))
        rest, noise = less.residual * (less.amplitude / whitened.amplitude), whitened.residual
        more = max(0.0, float(rest @ rest - noise @ noise)) / len(whitened.index)
        squares[joint] = more * whitened.noise[joint] ** 2
    return np.sqrt(squares)


def _scores(whitened: Whitened, joints: Sequence[int]) -> list[BayesFactor]:
    """Return the Bayes factors of all products on some joints, not tempered."""
    found = threads.side_by_side(lambda joint: _of_joint(whitened, joint), joints)
    whitened.forget()
    return [score for some in found for score in some]


def _of_joint(whitened: Whitened, joint: int) -> list[BayesFactor]:
    """Return the Bayes factors on one joint, from one Gram matrix of all columns."""
    raw, places = pool(whitened.x, joint)
    scale = expected(raw, float(whitened.spread[joint]))
    z = whitened.whitened(raw * scale, joint, coarse=True)
    span = whitened.explained.astype(z.dtype)
    before = np.einsum("nk,nk->k", z, z)
    z = z - span @ (span.T @ z)
    z[:, np.einsum("nk,nk->k", z, z) <= ROUNDING * before] = 0.0
    information = (z.T @ z).astype(np.float64)
    z *= whitened.residual.astype(z.dtype)[:, None]
    blocks = np.add.reduceat(z, whitened.starts, axis=0).astype(np.float64)
    by_width: dict[int, list[tuple[Product, Ints]]] = {}
    for product in products_of(whitened.x, joint):
        mine = np.concatenate([np.arange(raw.shape[1])[places[key]] for key in product.parts])
        by_width.setdefault(len(mine), []).append((product, mine))
    found = []
    for width, some in by_width.items():
        index = np.stack([mine for _, mine in some])
        matrix = information[index[:, :, None], index[:, None, :]]
        sums = blocks.sum(axis=0)[index]
        log_bf = tempered_log_bf(sums[:, None, :], matrix, np.ones(len(some)))[:, 0]
        parameters = np.linalg.solve(matrix + np.eye(width), sums[:, :, None])[:, :, 0]
        parameters *= scale[index]
        found += [
            BayesFactor(
                Candidate(product, joint),
                float(log_bf[n]),
                1.0,
                1.0,
                parameters[n],
                0.0,
                blocks[:, mine],
                matrix[n],
                blocks[:, 0],
            )
            for n, (product, mine) in enumerate(some)
        ]
    return found


def _refitted(whitened: Whitened, first: BayesFactor) -> tuple[BayesFactor, Whitened]:
    """Return the best product on the joint with hyperparameters that suit it, and that motion."""
    problem = refit(whitened, *explained_with(whitened, first.candidate))
    refitted = whitened.assuming(problem)
    scores = _scores(refitted, [first.candidate.joint])
    best = max(scores, key=lambda score: score.log_bf)
    (best,) = bayes_factors(refitted, [best.candidate])
    without = max(whitened.system.log_evidence, refitted.system.log_evidence)
    log_bf = log_bayes_factor_of(best, refitted, without)
    # Most of what its coefficients alone give may be rigid bodies' as well: count the rest.
    z = _whitened_torque(refitted, best)
    size = refitted.noise[best.candidate.joint] * np.sqrt(z @ z / len(refitted.index))
    return replace(best, log_bf=float(min(best.log_bf, log_bf)), size=float(size)), refitted


def _held_out(motion: HoldOutMotion, score: BayesFactor) -> tuple[bool, HoldOutMotion]:
    """Return whether a frozen torque holds on unseen motion, and that motion without it."""
    less = motion.less(score)
    return less.judged([(len(less.taken) - 1, score.candidate)]).holds, less


def _whitened_torque(whitened: Whitened, score: BayesFactor) -> Floats:
    """Return the torque (S N,) whitened, without what is explained already."""
    torque = score.candidate.columns(whitened.x) @ score.coefficients
    return whitened.project(whitened.whitened(torque[:, None], score.candidate.joint))[:, 0]
