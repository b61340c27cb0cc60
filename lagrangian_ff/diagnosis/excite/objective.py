"""The information of a motion about a question, and its slope by the motion.

With true coefficients b and the imitators Φ (what the model has, and a rival), the signal is
½ pᵀ M p, p = P b, M = G⁻¹ − G⁻¹ Φ (Φᵀ G⁻¹ Φ)⁻¹ Φᵀ G⁻¹. With w = M p and the coefficients c that Φ
imitates p with, its differential is wᵀ (dp − dΦ c − dK w), where dK moves the rows only: the slope
of what is left of the effect, h(x) = P(x) b − Φ(x) c − K(x, X) w, weighed by w. So one factor gives
the slope by all states.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.linalg import lapack, solve_triangular

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis.excite.assumed import Assumed, typical
from lagrangian_ff.diagnosis.excite.questions import Case
from lagrangian_ff.diagnosis.excite.splines import Splines
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.diagnosis.whitening import Whitened
from lagrangian_ff.diagnosis.whitening.whitened import TANGENT, tangent_terms
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.kernels import States
from lagrangian_ff.recording.motion import Motion

SOFT = 0.1
"""Width in the log of nats over which the least of several passes from one to the next."""
FAINT = 0.02
"""Weight below which a rival plays no part in the slope."""
STEP = 1e-6
"""Step of differences, relative to the largest value of a coordinate."""
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
        value: the mean of log (1 + signal) over the cases of the least group.
        nats: of the least group, the typical least signal over the rivals.
        pulls: how the value grows with the columns.
        weights: (S, N, D) how it grows with rigid-body torques.  share: (D,) the weight of each.
    """

    whitened: Whitened
    value: float
    nats: float
    pulls: list[Pull] = field(default_factory=list)
    weights: Floats = field(default_factory=lambda: np.empty(0))
    share: Floats = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True)
class Objective:
    """What is to be made large, as a function of control points.

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
        white: dict[object, Floats] = {}

        def whitened_once(one: Candidate) -> Floats:
            key = one.key, tuple(sorted(one.shape.items()))
            if key not in white:
                on = np.tile(one.term().on(whitened.joints), (len(one.effect.parameters), 1))
                white[key] = whitened.shared(one.columns(whitened.x), on)
            return white[key]

        values, parts, nats = [], [], []
        for group in self.groups:
            of_group: list[float] = []
            exact: list[float] = []
            for case in group:
                b = self.assumed.coefficients(case.true, self.size)
                z = whitened.project(whitened_once(case.true) * b)
                rest = [_beside(z, r and whitened.project(whitened_once(r))) for r in case.rivals]
                f = self.assumed.inflation.get(case.true.key, 1.0) * len(b)
                signals = np.array([0.5 * float(np.sum(one**2)) / f for one in rest])
                least, weights = softmin(np.log1p(signals))
                of_group.append(least)
                exact.append(float(signals.min()))
                parts.append((len(values), case, b, rest, weights / (1.0 + signals) / f))
            values.append(float(np.mean(of_group)))
            nats.append(typical(exact))
        value, of_groups = softmin(np.array(values))
        cases = len(parts)
        if self.dynamics:
            noise = np.tile(whitened.problem.variances, len(self.index))
            value += (whitened.system.log_det - float(np.sum(np.log(noise)))) / cases
        look = Look(whitened, value, min(nats))
        if not slope:
            return look
        weights, share = [], []
        for number, case, b, rest, by_signal in parts:
            by_signal = by_signal * of_groups[number] / len(self.groups[number])
            for rival, z, part in zip(case.rivals, rest, by_signal.tolist(), strict=True):
                if part * (1.0 + 0.5 * float(np.sum(z**2))) < FAINT / cases:
                    continue
                w = solve_triangular(whitened.system.upper, z, check_finite=False)
                white_design = whitened.system.white_design
                if rival is not None:
                    white_design = np.column_stack([white_design, whitened_once(rival)])
                c = _coefficients(white_design, whitened_once(case.true) * b)
                weights.append(w)
                share += [part] * len(b)
                look.pulls.extend(self._pulls(whitened, case.true, rival, part * w, b, c))
        shape = (len(self.index), whitened.joints, -1)
        return replace(look, weights=np.hstack(weights).reshape(shape), share=np.array(share))

    def _whitened(self, control: Floats) -> Whitened:
        """Return the samples whitened; effects with a memory see the motion between them."""
        x = self._inputs(control)
        whole = x.whole or x
        tau = np.random.default_rng(0).normal(size=whole.q.shape)
        joints = self.assumed.model.joints
        motion = Motion(joints, whole.time, whole.q, whole.qd, whole.qdd, tau, whole.segment)
        index = np.arange(len(x)) if x.index is None else x.index
        return self.assumed.whitened_at(motion, index, whole, x)

    def _inputs(self, control: Floats) -> Inputs:
        rows = slice(None) if self._remembers else self.index
        q, qd, qdd = (rate[rows] @ control for rate in self.splines.rates[:3])
        x = self._read(States.of(q, qd, qdd), self.splines.time[rows])
        return x.take(self.index) if self._remembers else x

    def _read(self, x: States, time: Floats) -> Inputs:
        """Return states as effects read them."""
        model = self.assumed.model
        segment = np.zeros(len(x), dtype=np.int64)
        if self._uses:
            read = model.with_torque(model.inputs(x.q, x.qd, x.qdd, time=time, segment=segment))
        else:
            read = Inputs.of(x, time, segment)
        return replace(read, sign_speed=self.assumed.problem.basis.sign_speed(x.joints))

    @property
    def _terms(self) -> Iterator[Term]:
        yield from self.assumed.problem.basis.terms
        for case in (case for group in self.groups for case in group):
            yield case.true.term()
            yield from (one.term() for one in case.rivals if one is not None)

    @property
    def _remembers(self) -> bool:
        return any(term.effect.remembers for term in self._terms)

    @property
    def _uses(self) -> bool:
        return any(term.effect.uses for term in self._terms)

    def _pulls(
        self,
        whitened: Whitened,
        true: Candidate,
        rival: Candidate | None,
        w: Floats,
        b: Floats,
        c: Floats,
    ) -> Iterator[Pull]:
        """Yield the pulls of one effect (P parameters) beside what imitates it.

        Args:
            w: (S N, P).  c: (B, P) the coefficients of the imitation.
        """
        joints, unit = whitened.joints, whitened.problem.unit
        by_joint = w.reshape(-1, joints, len(b)) / unit[:, None]

        def on(term: Term) -> Floats:
            return np.asarray(np.tensordot(term.on(joints), by_joint, axes=(0, 1)))

        yield Pull(true.term(), on(true.term()) * b)
        basis, last = whitened.basis, whitened.basis.size
        for term, place in basis.slices():
            yield Pull(term, -on(term) @ c[place].T)
        for up, down in tangent_terms(basis):
            factor = on(up) @ c[last : last + 1].T / TANGENT
            yield Pull(up, -factor)
            yield Pull(down, factor)
            last += 1
        if rival is not None:
            yield Pull(rival.term(), -on(rival.term()) @ c[last:].T)

    def slope(self, look: Look, control: Floats) -> Floats:
        """Return (K, N) the slope of the value by the control points."""
        whitened, x = look.whitened, look.whitened.x
        still = replace(x, whole=None, index=None, window=1)
        states = States.of(x.q, x.qd, x.qdd)
        kernel, joints = whitened.problem.kernel, whitened.joints
        plain = kernel.cross(states, states)
        flat = look.weights.reshape(-1, len(look.share))
        pulled = flat * look.share
        precision = _inverse(whitened.system.upper) if self.dynamics else None
        here = [pull for pull in _merged(look.pulls) if not pull.term.effect.remembers]
        before = _sums(here, still)
        out = np.zeros_like(control)
        for order, name in enumerate(("q", "qd", "qdd")):
            step = STEP * max(float(np.abs(getattr(x, name)).max()), 1e-3)
            by_state = np.zeros_like(x.q)
            for n in range(joints):
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
                if self._uses:
                    read = self._read(other, x.time)
                    seen = replace(seen, load=read.load, torque=read.torque)
                by_state[:, n] += _sums(here, seen) - before
            out += self.splines.rates[order][self.index].T @ (by_state / step)
        return out + self._slope_of_memory(look, control)

    @property
    def _cases(self) -> int:
        return sum(len(group) for group in self.groups)

    def _slope_of_memory(self, look: Look, control: Floats) -> Floats:
        """Return (K, N) the slope by effects with a memory, by their own joint alone."""
        out = np.zeros_like(control)
        pulls = [pull for pull in _merged(look.pulls) if pull.term.effect.remembers]
        nearest = np.abs(self.splines.places[:, None] - look.whitened.x.time).argmin(axis=0)
        for joint in {pull.term.effect.cause(pull.term.joint, pull.term.shape) for pull in pulls}:
            here = [p for p in pulls if p.term.effect.cause(p.term.joint, p.term.shape) == joint]
            before = _sums(here, look.whitened.x)
            for colour in range(COLOURS):
                step = np.zeros(len(control))
                step[colour::COLOURS] = STEP
                moved = control.copy()
                moved[:, joint] += step
                change = (_sums(here, self._inputs(moved)) - before) / STEP
                mine = np.abs(nearest[:, None] - np.arange(len(control))[colour::COLOURS])
                whose = np.arange(len(control))[colour::COLOURS][mine.argmin(axis=1)]
                np.add.at(out[:, joint], whose, change)
        return out


def softmin(values: Floats) -> tuple[float, Floats]:
    """Return a smooth least of some values, and its slope by each."""
    least = float(values.min())
    part = np.exp(-(values - least) / SOFT)
    return least - SOFT * float(np.log(part.sum())), part / part.sum()


def _beside(z: Floats, rival: Floats | None) -> Floats:
    """Return whitened columns with those of a rival projected out."""
    if rival is None:
        return z
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
