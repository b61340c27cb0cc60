"""The information of a motion about a question, and its slope by the motion.

With true coefficients b and the imitators Φ (what the model has, and a rival), the signal is
½ pᵀ M p, p = P b, M = G⁻¹ − G⁻¹ Φ (Φᵀ G⁻¹ Φ)⁻¹ Φᵀ G⁻¹. With w = M p and the coefficients c that Φ
imitates p with, its differential is wᵀ (dp − dΦ c − dK w), where dK moves the rows only: the slope
of what is left of the effect, h(x) = P(x) b − Φ(x) c − K(x, X) w, weighed by w. So one factor gives
the slope by all states.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.linalg import lapack, solve_triangular

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.excite.assumed import Assumed, refitted, typical
from lagrangian_ff.diagnosis.excite.path import Reference
from lagrangian_ff.diagnosis.excite.questions import Case
from lagrangian_ff.diagnosis.excite.reading import STEP, Reading, of_whole
from lagrangian_ff.diagnosis.excite.splines import Splines
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.diagnosis.whitening import Whitened
from lagrangian_ff.diagnosis.whitening.errors import TANGENT
from lagrangian_ff.diagnosis.whitening.whitened import chain_of
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.kernels import States
from lagrangian_ff.recording.motion import Motion

SOFT = 0.1
"""Width in the log of nats over which the least of several passes from one to the next."""
SEEN = 0.5
"""Weight of seeing an effect at all, beside telling it from its look-alikes: where these cannot be
told apart, the motion is to show at least that something is there."""
FAINT = 0.02
"""Share of the largest weight below which a rival plays no part in the slope."""
COLOURS = 9
"""Control points this far apart do not move the same stretch of a motion."""


@dataclass(frozen=True)
class Pull:
    """A term's columns (S, P) and the factors whose sum of products has the slope of the value."""

    term: Term
    factor: Floats


@dataclass(frozen=True)
class Look:
    """A motion as an objective sees it.

    Attributes:
        value: the mean over the cases of the least group of log (1 + signal / need) against the
            rival that imitates best, and a share of the same against the plain model.
        pulls: how the value grows with the columns.
        weights: (S, N, P) each, how it grows with rigid-body torques.
        shares: the weight of each of these columns.
    """

    whitened: Whitened
    value: float
    pulls: list[Pull] = field(default_factory=list)
    weights: list[Floats] = field(default_factory=list)
    shares: list[float] = field(default_factory=list)


@dataclass(frozen=True)
class Objective:
    """The objective of the search, as a function of control points.

    Attributes:
        groups: of cases, see `cases_of`.  size: of the effects.
        index: (S,) the samples of the splines' time that are looked at.
        dynamics: whether the information about the rigid bodies counts too.
    """

    assumed: Assumed
    groups: Sequence[Sequence[Case]]
    splines: Splines
    size: float
    index: Ints
    dynamics: bool = False

    def look(self, control: Floats, slope: bool = True) -> Look:
        """Return the value of control points (K, N), and what its slope needs."""
        whitened = self._whitened(control)
        judged = [judge(whitened, group, self.assumed, self.size) for group in self.groups]
        softened = [[one.worth for one in group] for group in judged]
        means = [float(np.mean([least for least, _ in group])) for group in softened]
        value, of_groups = softmin(np.array(means)) if means else (0.0, np.zeros(0))
        if self.dynamics:
            value += 2.0 * learned(whitened) / self._cases
        look = Look(whitened, value)
        if slope:
            for number, (group, soft) in enumerate(zip(judged, softened, strict=True)):
                for one, (_, weights) in zip(group, soft, strict=True):
                    share = of_groups[number] / len(group) * weights
                    self._pull(look, one, share)
        return look

    def _pull(self, look: Look, one: "Judged", share: Floats) -> None:
        """Add how the value grows with one case.

        Args:
            share: (R,) of the log of each signal in the value.
        """
        whitened, b = look.whitened, one.b
        joints, unit = whitened.joints, whitened.problem.unit
        for number in np.flatnonzero(share > FAINT * share.max()).tolist():
            by_squares = share[number] / (one.needs + one.signals)[number] / one.divisor
            rival, white = one.case.rivals[number], one.rivals[number]
            known = whitened.system.white_design
            known = known if white is None else np.column_stack([known, white])
            c = _coefficients(known, one.white)
            w = solve_triangular(whitened.system.upper, one.left[number], check_finite=False)
            by_joint = w.reshape(-1, joints, len(b))
            look.weights.append(by_joint)
            look.shares.extend([by_squares] * len(b))
            look.pulls.extend(
                _pulls(
                    whitened.basis,
                    one.case.true,
                    rival,
                    by_squares * by_joint / unit[:, None],
                    b,
                    c,
                )
            )

    def _whitened(self, control: Floats) -> Whitened:
        """Return the samples whitened; effects with a memory see the motion between them."""
        x = self._reading.of(control)
        whole = x.whole or x
        tau = np.random.default_rng(0).normal(size=whole.q.shape)
        joints = self.assumed.model.joints
        motion = Motion(joints, whole.time, whole.q, whole.qd, whole.qdd, tau, whole.segment)
        index = np.arange(len(x)) if x.index is None else x.index
        return self.assumed.whitened_at(motion, index, whole, x)

    @cached_property
    def _reading(self) -> Reading:
        model = self.assumed.model
        width = self.assumed.problem.basis.sign_speed(len(model.joints))
        return Reading(model, tuple(self._terms), self.splines, self.index, width)

    @property
    def _terms(self) -> Iterator[Term]:
        yield from self.assumed.problem.basis.terms
        for case in (case for group in self.groups for case in group):
            yield case.true.term()
            yield from (one.term() for one in case.rivals if one is not None)

    def slope(self, look: Look, control: Floats, free: Sequence[int] | None = None) -> Floats:
        """Return (K, N) the slope of the value by the control points.

        Args:
            free: joints that it is wanted for; it is zero for others. None is all.
        """
        whitened, x = look.whitened, look.whitened.x
        still = replace(x, whole=None, index=None, window=1)
        states = States.of(x.q, x.qd, x.qdd)
        kernel, joints = chain_of(whitened.problem), whitened.joints
        plain = kernel.cross(states, states)
        flat = np.concatenate([np.zeros((len(x), joints, 0)), *look.weights], axis=2)
        flat = flat.reshape(len(plain), -1)
        pulled = flat * np.array(look.shares)
        precision = _inverse(whitened.system.upper) if self.dynamics else None
        here = [pull for pull in _merged(look.pulls) if not pull.term.effect.remembers]
        before = _sums(here, still)
        out = np.zeros_like(control)
        free = range(joints) if free is None else free
        for order, name in enumerate(("q", "qd", "qdd")):
            step = STEP * max(float(np.abs(getattr(x, name)).max()), 1e-3)
            by_state = np.zeros_like(x.q)
            for n in free:
                moved = {one: getattr(x, one) for one in ("q", "qd", "qdd")}
                moved[name] = moved[name].copy()
                moved[name][:, n] += step
                other = States.of(**moved)
                rows = kernel.cross(other, states) - plain
                change = -np.sum((rows @ flat) * pulled, axis=1)
                if precision is not None:
                    change += 2.0 * np.sum(precision * rows, axis=1) / self._cases
                by_state[:, n] = change.reshape(-1, joints).sum(axis=1)
                seen = replace(still, **moved)
                if self._reading.uses:
                    seen = self._reading.loaded(seen)
                by_state[:, n] += _sums(here, seen) - before
            out += self.splines.rates[order][self.index].T @ (by_state / step)
        return out + self._slope_of_memory(look, control, free)

    @property
    def _cases(self) -> int:
        return max(1, sum(len(group) for group in self.groups))

    def _slope_of_memory(self, look: Look, control: Floats, free: Sequence[int]) -> Floats:
        """Return (K, N) the slope by effects with a memory, by their own joint alone."""
        out = np.zeros_like(control)
        pulls = [pull for pull in _merged(look.pulls) if pull.term.effect.remembers]
        nearest = np.abs(self.splines.places[:, None] - look.whitened.x.time).argmin(axis=0)
        causes = {pull.term.effect.cause(pull.term.joint, pull.term.shape) for pull in pulls}
        of = {
            joint: [p for p in pulls if p.term.effect.cause(p.term.joint, p.term.shape) == joint]
            for joint in causes.intersection(free)
        }
        before = {joint: _sums(here, look.whitened.x) for joint, here in of.items()}
        rates = self._reading.rates
        ways = [rate @ control for rate in rates] if of else []
        terms = {joint: [pull.term for pull in here] for joint, here in of.items()}
        looking = [joint for joint, own in terms.items() if of_whole(own)]
        whole = look.whitened.x.whole
        near = self._reading.nearby(ways, whole.load, looking) if whole and looking else {}
        for colour in range(COLOURS if of else 0):
            every = np.arange(len(control))[colour::COLOURS]
            steps = [STEP * rate[:, every].sum(axis=1) for rate in rates]
            whose = every[np.abs(nearest[:, None] - every).argmin(axis=1)]
            for joint, here in of.items():
                column = np.arange(control.shape[1]) == joint
                moved = [w + np.outer(s, column) for w, s in zip(ways, steps, strict=True)]
                load = near[joint].at(steps) if joint in near else None
                x = self._reading.of_ways(moved, terms[joint], load)
                change = (_sums(here, x) - before[joint]) / STEP
                np.add.at(out[:, joint], whose, change)
        return out


@dataclass(frozen=True)
class Judged:
    """A case in a motion.

    Attributes:
        b: (P,) the true coefficients, each as if it were the only one.
        white: (S N, P) the whitened columns times b.
        rivals: those of each rival, (S N, R); None for the plain model.
        left: for each rival the whitened columns times b, (S N, P), that it cannot imitate.
        divisor: of half their squares, which makes them nats.
    """

    case: Case
    b: Floats
    white: Floats
    rivals: list[Floats | None]
    left: list[Floats]
    divisor: float

    @property
    def signals(self) -> Floats:
        """Return (R,) nats that decide against each rival."""
        return np.array([0.5 * float(np.sum(one**2)) for one in self.left]) / self.divisor

    @property
    def needs(self) -> Floats:
        """Return (R,) nats that a verdict needs against each: to claim an effect, or to name it."""
        limits = thresholds.USED
        name = limits.rival_deviations * limits.rival_nats
        return np.array([limits.floor if one is None else name for one in self.case.rivals])

    @property
    def worth(self) -> tuple[float, Floats]:
        """Return the value of the case, and (R,) its slope by the log of each 1 + signal / need."""
        logs = np.log1p(self.signals / self.needs)
        value, weights = softmin(logs)
        if len(logs) > 1 and self.case.rivals[0] is None:
            value += SEEN * float(logs[0])
            weights[0] += SEEN
        return value, weights


def judge(whitened: Whitened, group: Sequence[Case], assumed: Assumed, size: float) -> list[Judged]:
    """Return cases as a motion shows them."""
    white: dict[object, Floats] = {}

    def white_of(one: Candidate) -> Floats:
        key = one.key, tuple(sorted(one.shape.items()))
        if key not in white:
            on = np.tile(one.term().on(whitened.joints), (len(one.effect.parameters), 1))
            white[key] = whitened.shared(one.columns(whitened.x), on)
        return white[key]

    found = []
    for case in group:
        b = assumed.coefficients(case.true, size)
        z = white_of(case.true) * b
        rivals = [None if one is None else white_of(one) for one in case.rivals]
        own = whitened.project(z)
        left = [own if one is None else _beside(own, whitened.project(one)) for one in rivals]
        divisor = assumed.inflation[case.true.key] * len(b)
        found.append(Judged(case, b, z, rivals, left, divisor))
    return found


def learned(whitened: Whitened) -> float:
    """Return the nats that a motion tells of the rigid bodies, ½ log det (I + D⁻¹ K).

    K is linear in the base parameters, so the most of them is D-optimal, with the kernel as prior.
    """
    system = whitened.system
    return 0.5 * (system.log_det - float(np.sum(np.log(system.noise))))


def nats_of(
    assumed: Assumed, groups: Sequence[Sequence[Case]], made: Reference, size: float
) -> float:
    """Return the nats that a motion is expected to give to decide a question.

    Of each effect against the rival that imitates it best, the typical one of the least group.
    Without groups, those that it tells of the rigid bodies.
    """
    whitened = assumed.whitened(made)
    if not groups:
        return learned(whitened)
    judged = [judge(whitened, group, assumed, size) for group in groups]
    count = len(whitened.index)
    return min(
        typical(
            float(refitted(one.signals.min(), count / assumed.inflation[one.case.true.key]))
            for one in group
        )
        for group in judged
    )


def _pulls(
    basis: Basis, true: Candidate, rival: Candidate | None, weight: Floats, b: Floats, c: Floats
) -> Iterator[Pull]:
    """Yield the pulls of one effect (P parameters) beside what imitates it.

    Args:
        weight: (S, N, P) of the torques.  c: (B, P) the coefficients of the imitation.
    """

    def on(term: Term) -> Floats:
        return np.asarray(np.einsum("n,snp->sp", term.on(weight.shape[1]), weight))

    yield Pull(true.term(), on(true.term()) * b)
    for term, place in basis.slices():
        yield Pull(term, -on(term) @ c[place].T)
    last = basis.size
    for up, down in basis.tangents(TANGENT):
        factor = on(up) @ c[last : last + 1].T / TANGENT
        yield Pull(up, -factor)
        yield Pull(down, factor)
        last += 1
    if rival is not None:
        yield Pull(rival.term(), -on(rival.term()) @ c[last:].T)


def softmin(values: Floats) -> tuple[float, Floats]:
    """Return a smooth least of some values, and its slope by each."""
    least = float(values.min())
    part = np.exp(-(values - least) / SOFT)
    return least - SOFT * float(np.log(part.sum())), part / part.sum()


def _beside(z: Floats, rival: Floats) -> Floats:
    """Return whitened columns with those of a rival projected out."""
    size = np.sqrt(np.sum(rival**2, axis=0))
    span, triangle = np.linalg.qr(rival / np.where(size > 0.0, size, 1.0))
    span = span[:, np.abs(np.diag(triangle)) > 1e-6]
    return np.asarray(z - span @ (span.T @ z))


def _coefficients(white: Floats, target: Floats) -> Floats:
    """Return (B, P) the coefficients of columns (n, B) of any units that imitate the target."""
    size = np.sqrt(np.sum(white**2, axis=0))
    scaled = white / np.where(size > 0.0, size, 1.0)
    found, *_ = np.linalg.lstsq(scaled, target, rcond=1e-9)
    return np.asarray(found / np.where(size > 0.0, size, np.inf)[:, None])


def _merged(pulls: Sequence[Pull]) -> list[Pull]:
    """Return the pulls with those of one term added up."""
    merged: dict[tuple[object, ...], Pull] = {}
    for pull in pulls:
        term = pull.term
        key = term.effect.name, term.joint, tuple(sorted(term.shape.items()))
        old = merged.get(key)
        merged[key] = pull if old is None else Pull(term, old.factor + pull.factor)
    return list(merged.values())


def _sums(pulls: Sequence[Pull], x: Inputs) -> Floats:
    """Return (S,) the sum of the products of columns and factors at each sample."""
    parts = [np.sum(pull.term.columns(x) * pull.factor, axis=1) for pull in pulls]
    return np.asarray(sum(parts, np.zeros(len(x))))


def _inverse(upper: Floats) -> Floats:
    inverse, _ = lapack.dpotri(upper, lower=0)
    return np.asarray(np.triu(inverse) + np.triu(inverse, 1).T)
