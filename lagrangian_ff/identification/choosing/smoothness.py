"""The smoothness of a curve, chosen by the evidence; and curves that only rise or only fall.

The basis of a model is not penalised (`system`). So the prior of a curve does not enter the fit: it
decides which directions of the heights are free in it. A priori the second differences of the
heights s are normal with variance s²/λ (Eilers and Marx 1996, Stat. Sci. 11(2); over two
coordinates those of a thin plate). With the curve's columns Z and the torques w, both whitened and
without what the basis has, the log evidence is

    −½ (ν log(w² − wᵀZ (ZᵀZ + λS)⁻¹ Zᵀw) + log |ZᵀZ + λS| − log |λS|).

In the directions v of ZᵀZ v = γ S v all of it is sums. Free are those with γ ≥ λ / 10, which a
penalised fit would shrink by less than ten elevenths: one too many costs its noise, one too few its
torque, which is more. How the B-splines are spaced is chosen likewise.
"""

from collections.abc import Iterator
from itertools import product

import numpy as np
import scipy
from scipy.linalg import eigh, solve_triangular

from lagrangian_ff.arrays import Flags, Floats
from lagrangian_ff.effects import Inputs
from lagrangian_ff.effects.curve import Axis, Curve
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.choosing.shapes import orthonormal, system_of
from lagrangian_ff.identification.solving.posterior import Posterior
from lagrangian_ff.identification.solving.solution import Solution
from lagrangian_ff.identification.solving.system import System

BENDS, BENDS_OF_TWO = (16, 48), (7, 12)
"""Numbers of bends tried, over one coordinate and over each of two."""
SPACINGS = ("even", "dense", "zero")
"""Even, closer where there are more samples, and closer about zero, where friction bends."""
ABOUT_ZERO = ("velocity", "reversal")
"""Coordinates that are spaced about zero."""
ABOUT = 2.5
"""Power of an even spacing that is closer about zero."""
LOOSE = 1e-6
"""Precision of the heights themselves, relative to that of their second differences."""
ROUNDING, UNDETERMINED = 1e-12, 1e-8
"""Shares of the largest eigenvalue: one below is rounding, or leaves steps undetermined."""
SEEN = 1e-3
"""Variance of a step of a monotone curve, over that of the largest, below which it is left out."""
LAMBDAS = np.geomspace(1e-9, 1e9, 73)
"""λ tried, relative to the mean of γ."""
LEAST = 3.0
"""Nats that a curve must gain; with less the data show nothing of it."""
KEPT = 0.1
"""Least γ/λ of a direction that is free."""
NOTHING = 1e-6
"""Share of a direction below which the basis has it already."""
HELD = 1e-3
"""Share of a direction below which what the basis has can do as well."""


def smooth(found: Posterior[System], wish: Curve, joint: int, learned: Inputs) -> Curve:
    """Return a curve with the B-splines and free directions of largest evidence.

    Args:
        found: posterior of the model without the curve.
        wish: over what, and of which kind.  joint: that it acts on.
        learned: all of the motion that is learned from: what it has seen.

    Raises:
        ModelError: the motion does not move the coordinates, or shows nothing of such a curve.
    """
    at = [one.read(learned, joint) for one in wish.over]
    for values, one in zip(at, wish.over, strict=True):
        if not np.ptp(values) > 1e-9 * max(1.0, float(np.abs(values).max())):
            raise ModelError(f"a curve over {one.words}: that does not change in the model's data")
    tried = [_tried(found, wish, joint, at, axes) for axes in _axes(wish, at)]
    gain, best = max(tried, key=lambda one: one[0])
    if not np.isfinite(gain) or not best.heights.shape[1]:
        raise ModelError(f"the model's data show nothing of {wish.meaning}")
    return _rising(found, best, joint, at[0]) if wish.monotone else best


def _axes(wish: Curve, at: list[Floats]) -> Iterator[tuple[Axis, ...]]:
    """Yield the spacings that are tried, the same on all coordinates."""
    for count, spacing in product(BENDS if len(at) == 1 else BENDS_OF_TWO, SPACINGS):
        if spacing != "zero" or any(one.kind in ABOUT_ZERO for one in wish.over):
            each = zip(wish.over, at, strict=True)
            yield tuple(
                _axis(values, count, spacing if one.kind in ABOUT_ZERO else "even"
                      if spacing == "zero" else spacing, odd=wish.odd and not n)
                for n, (one, values) in enumerate(each)
            )  # fmt: skip


def _axis(values: Floats, count: int, spacing: str, *, odd: bool) -> Axis:
    """Return B-splines between bends that are spaced by one of `SPACINGS`."""
    if odd:
        values = np.concatenate([values, -values])
    low, high = float(values.min()), float(values.max())
    bends = np.linspace(low, high, count)
    if spacing == "dense":  # half of the way, so that no two bends meet where the joint rests
        bends = 0.5 * (bends + np.quantile(values, np.linspace(0.0, 1.0, count)))
    if spacing == "zero":
        ends = [float(np.sign(end) * np.abs(end) ** (1.0 / ABOUT)) for end in (low, high)]
        bends = np.linspace(ends[0], ends[1], count)
        bends = np.sign(bends) * np.abs(bends) ** ABOUT
    if odd:
        bends = 0.5 * (bends - bends[::-1])
    return Axis(tuple(bends.tolist()))


def _tried(
    found: Posterior[System], wish: Curve, joint: int, at: list[Floats], axes: tuple[Axis, ...]
) -> tuple[float, Curve]:
    """Return the log evidence that one spacing gains with the best smoothness, and the curve."""
    seen = _seen(axes, at, odd=wish.odd)
    span = _span(axes, seen, odd=wish.odd)
    whole, z, w = _whitened(found, wish.made(axes, seen, span), joint)
    penalty = span.T @ _penalty([axis.count for axis in axes]) @ span
    penalty += LOOSE * span.T @ span
    gamma, directions = eigh(z.T @ z, penalty)
    gamma = np.maximum(gamma, 0.0)
    if not gamma.any():
        return -np.inf, wish
    _, _, system = system_of(found, joint)
    lambdas = np.mean(gamma) * LAMBDAS[:, None]
    explained = np.sum((directions.T @ (z.T @ w)) ** 2 / (gamma + lambdas), axis=1)
    left = np.maximum(w @ w - explained, 1e-300)
    price = np.sum(np.log1p(gamma / lambdas), axis=1)
    evidence = -0.5 * (system.degrees * np.log(left) + price)
    best = int(np.argmax(evidence))
    gain = float(evidence[best] + 0.5 * system.degrees * np.log(w @ w))
    if gain < LEAST:
        return -np.inf, wish
    own = gamma > NOTHING * np.sum((whole @ directions) ** 2, axis=0)
    free = span @ directions[:, own & (gamma >= KEPT * lambdas[best])][:, ::-1]
    known = span @ _known(found, wish.made(axes, seen, span), joint, penalty)
    return gain, _small(wish.made(axes, seen, free), known)


def _known(found: Posterior[System], curve: Curve, joint: int, penalty: Floats) -> Floats:
    """Return (P, R) the smooth directions of a curve that are columns of the basis on its joint."""
    x = found.problem.samples.x
    columns = Term(curve, joint).columns(x)
    others = [t.columns(x) for t in found.problem.basis.terms if t.joint == joint]
    there = np.column_stack([np.zeros((len(x), 0)), *others])
    matrix = columns.T @ columns
    stiff = LOOSE * np.trace(matrix) / np.trace(penalty) * penalty
    heights = np.linalg.solve(matrix + stiff, columns.T @ there)
    left = np.sum((there - columns @ heights) ** 2, axis=0)
    return np.asarray(heights[:, left < HELD * np.sum(there**2, axis=0)])


def _small(made: Curve, known: Floats) -> Curve:
    """Return a curve without what the basis can do as well, as large as it could be otherwise.

    A slope over velocity may be the curve's or that of viscous friction. What is the curve's ends
    with its range, so that as little as possible should be.

    Args:
        known: (K, R) heights of what the basis has as well.
    """
    heights = made.heights
    if known.shape[1]:
        _, values = made.along()
        _, there = made.made(made.axes, made.seen, known).along()
        heights = heights - known @ np.linalg.lstsq(there, values, rcond=None)[0]
    size, before = (np.abs(one).max(axis=0, initial=0.0) for one in (heights, made.heights))
    left = size > HELD * before
    return made.made(made.axes, made.seen, heights[:, left] / size[left])


def _seen(axes: tuple[Axis, ...], at: list[Floats], *, odd: bool) -> Flags:
    """Return (K,) which B-splines, or products of them, have a sample in them."""
    counts = [axis.count for axis in axes]
    seen = np.zeros(counts, dtype=bool)
    every = [axis.weights(values) for axis, values in zip(axes, at, strict=True)]
    for steps in product(range(4), repeat=len(axes)):
        inside = np.all(
            [values[:, n] > 0.0 for n, (_, values) in zip(steps, every, strict=True)], axis=0
        )
        seen[tuple((first + n)[inside] for n, (first, _) in zip(steps, every, strict=True))] = True
    return (seen | seen[::-1] if odd else seen).ravel()


def _span(axes: tuple[Axis, ...], seen: Flags, *, odd: bool) -> Floats:
    """Return (K, k) the heights that are possible: zero where nothing was seen, and odd."""
    count = len(seen)
    if not odd:
        return np.eye(count)[:, seen]
    numbers = np.arange(count).reshape([axis.count for axis in axes])
    mirrored = numbers[::-1].ravel()
    upper = np.flatnonzero(seen & (numbers.ravel() > mirrored))
    out = np.zeros((count, len(upper)))
    out[upper, np.arange(len(upper))] = 1.0
    out[mirrored[upper], np.arange(len(upper))] = -1.0
    return out


def _penalty(counts: list[int]) -> Floats:
    """Return (K, K) S, the squares of second differences; of two coordinates, of a thin plate."""
    bent = [np.diff(np.eye(count), 2, axis=0) for count in counts]
    if len(counts) == 1:
        return np.asarray(bent[0].T @ bent[0])
    steep = [np.diff(np.eye(count), axis=0) for count in counts]
    rows = [
        np.kron(bent[0], np.eye(counts[1])),
        np.kron(np.eye(counts[0]), bent[1]),
        np.sqrt(2.0) * np.kron(*steep),
    ]
    return np.asarray(sum(one.T @ one for one in rows))


def _whitened(found: Posterior[System], curve: Curve, joint: int) -> tuple[Floats, Floats, Floats]:
    """Return a curve's whitened columns (n, P), and these and the torques (n,) less the basis."""
    joints, _, system = system_of(found, joint)
    columns = Term(curve, joint).columns(found.problem.samples.x)
    full = np.zeros((len(columns), len(joints), columns.shape[1]))
    full[:, joints.index(joint)] = columns / found.problem.unit[joint]
    flat = full.reshape(-1, columns.shape[1])
    whole = solve_triangular(system.upper, flat, trans=1, check_finite=False)
    span = orthonormal(system.white_design)
    w = system.white_target - span @ (span.T @ system.white_target)
    return whole, whole - span @ (span.T @ whole), w


def _rising(found: Posterior[System], best: Curve, joint: int, at: Floats) -> Curve:
    """Return the curve in steps between neighbouring heights, which are its parameters.

    As many steps as the smooth curve has free directions, twice over: a sum of few steps bends
    less. It rises or falls, whichever explains more.
    """
    axis = _axis(at, max(4, 2 * best.heights.shape[1]), "dense", odd=best.odd)
    seen = np.ones(axis.count, dtype=bool)
    steps = np.tril(np.ones((axis.count, axis.count)))[:, 1:]
    steps -= 0.5 * (steps[:1] + steps[-1:])
    if best.odd:
        steps = (steps + steps[:, ::-1])[:, : axis.count // 2] / 2.0
    first, weights = axis.weights(at)
    values = sum(weights[:, n, None] * steps[first + n] for n in range(4))
    if not best.odd:  # about its mean, so that it takes nothing from a constant torque
        steps = steps - np.mean(values, axis=0)
    size = np.var(values, axis=0)
    steps = steps[:, size > SEEN * size.max()]  # one at an end may be of a few samples
    both = [best.made((axis,), seen, sign * steps) for sign in (1.0, -1.0)]
    falls = []
    for one in both:
        _, z, w = _whitened(found, one, joint)
        falls.append(-float(scipy.optimize.nnls(z, w)[1]))
    return both[int(np.argmax(falls))]


def without_bounds(solution: Solution, part: Basis) -> Basis | None:
    """Return a basis whose monotone curves lack the steps that are 0 in the bounded optimum.

    The parameters b of the basis minimise ½ bᵀ I b − mᵀ b, with I the information and m the moment
    of the solution. Where the steps of monotone curves are held at 0 or above, those at the bound
    are an active set: the fit without them is the bounded optimum (Karush, Kuhn, Tucker), but for
    steps that the data leave undetermined, which are left out as well.

    Returns:
        The smaller basis, or None if every step is above zero already.

    Raises:
        ModelError: a curve has no step left.
    """
    low = np.full(part.size, -np.inf)
    for term, place in part.slices():
        if isinstance(term.effect, Curve) and term.effect.monotone:
            low[place] = 0.0
    if not np.isfinite(low).any() or (solution.coefficients[low == 0.0] > 0.0).all():
        return None
    bounded = low == 0.0
    scale = np.sqrt(np.maximum(np.diag(solution.information), 1e-300))
    matrix, right = solution.information / np.outer(scale, scale), solution.moment / scale
    others = np.linalg.pinv(matrix[np.ix_(~bounded, ~bounded)], rcond=1e-12, hermitian=True)
    across = matrix[np.ix_(bounded, ~bounded)] @ others
    own = matrix[np.ix_(bounded, bounded)] - across @ matrix[np.ix_(~bounded, bounded)]
    free = np.ones(part.size, dtype=bool)
    free[bounded] = _above_zero(own, right[bounded] - across @ right[~bounded])
    if free.all():  # but for rounding
        free = ~bounded | (solution.coefficients > 0.0)
    terms = []
    for term, place in part.slices():
        effect = term.effect
        if isinstance(effect, Curve) and effect.monotone:
            if not free[place].any():
                raise ModelError(f"{effect.meaning}: the data neither rise nor fall with it")
            kept = effect.made(effect.axes, effect.seen, effect.heights[:, free[place]])
            term = Term(kept, term.joint)
        terms.append(term)
    return Basis(tuple(terms))


def _above_zero(matrix: Floats, moment: Floats) -> Flags:
    """Return (P,) which of P numbers d >= 0 are above 0 where ½ dᵀ M d − mᵀ d is least.

    Of several such d, as where a slope is the curve's or that of viscous friction, it is one with
    so many at 0 that no other has the same above 0.
    """
    values, vectors = eigh(matrix)
    root = np.sqrt(np.maximum(values, ROUNDING * values[-1]))
    found, _ = scipy.optimize.nnls(root[:, None] * vectors.T, (vectors / root).T @ moment)
    while True:
        free = np.flatnonzero(found > 0.0)
        values, vectors = eigh(matrix[np.ix_(free, free)])
        if len(free) < 2 or values[0] > UNDETERMINED * values[-1]:
            return np.asarray(found > 0.0)
        away = vectors[:, 0] * np.sign(vectors[:, 0].sum() or 1.0)
        reach = np.where(away > 0.0, found[free] / np.maximum(away, 1e-300), np.inf)
        first = int(np.argmin(reach))
        found[free] -= reach[first] * away
        found[free[first]] = 0.0
        found = np.maximum(found, 0.0)
