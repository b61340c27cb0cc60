"""The hold-out: frozen findings judged on motion that the search did not use."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.confidence import Doubt, HoldOut, Reason
from lagrangian_ff.diagnosis.intervals import reach_of_all
from lagrangian_ff.diagnosis.results import Change
from lagrangian_ff.diagnosis.search.bayes_factor import BayesFactor
from lagrangian_ff.diagnosis.search.candidates import Candidate, bends_over_speed
from lagrangian_ff.diagnosis.search.carried import Carried
from lagrangian_ff.diagnosis.search.fitted import Fitted
from lagrangian_ff.diagnosis.search.forward import Search
from lagrangian_ff.diagnosis.search.lag import column_of, hysteresis_of
from lagrangian_ff.diagnosis.whitening import Whitened, counting_less, whiten
from lagrangian_ff.diagnosis.whitening.blocks import shortest_seconds
from lagrangian_ff.diagnosis.whitening.hyperparameters import used
from lagrangian_ff.effects import Inputs
from lagrangian_ff.effects.reversals import travelled
from lagrangian_ff.identification.basis import Basis, shares
from lagrangian_ff.identification.problem import Nuisance
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.sampling import recorded_seconds

ROUNDING = 1e-9
BEYOND = 2.0
"""Distance from a reversal at which hysteresis is over, over that within which it builds up."""
MOST_MORE = 600.0
"""s of motion beyond which another motion is better than more of this one."""


@dataclass(frozen=True)
class HoldOutMotion:
    """Hold-out motion, whitened as the searched one, with all findings subtracted.

    Attributes:
        whitened: the motion; its residual has every frozen finding subtracted, and the model's own
            effects fitted to this motion alone.
        residual: (S N,) the same, with its friction as the searched motion leaves it.
        found: the motion of the search, with all findings.
        carried: what it says of the model's friction; None for nothing.
        taken: for each finding, its torque (S,) N·m on this motion and (S',) on that of the search.
    """

    whitened: Whitened
    residual: Floats
    found: Whitened
    carried: Carried | None
    taken: tuple[tuple[Floats, Floats], ...]

    @classmethod
    def of(
        cls,
        motion: Motion,
        found: Whitened,
        model: Basis,
        taken: Sequence[tuple[Candidate, Floats]],
        change: Change | None = None,
    ) -> "HoldOutMotion":
        """Return a motion whitened with hyperparameters and effects that come from another.

        Args:
            motion: not used in the search.
            found: the motion of the search, with all findings.
            model: the basis of the model, its shapes fitted. Its parameters stay free, those of
                friction as far as `Carried` leaves them.
            taken: the findings with frozen parameters. One with no parameters, (0,), is fitted to
                this motion, as a curve always is, and the load is predicted without it.
            change: where this motion takes up a load, if the first one did.
        """
        assumed = found.problem
        if assumed.change is not None:
            assumed = replace(assumed, change=change.prior if change else None)
        index, seconds = used(motion), found.seconds
        whole = Basis((*model.terms, *(c.term() for c, b in taken if c.named and len(b))))
        assumed = replace(assumed.having(basis=whole), nuisance=())
        lags = found.lagging
        whitened = whiten(motion, index, seconds, found.inputs_of(motion), assumed, lagging=lags)
        inputs = whitened.inputs_of(motion)
        x = replace(whitened, inputs=inputs).inputs_left_out()
        tau = motion.tau.copy()
        torques, nuisance = [], []
        for candidate, parameters in taken:
            if not candidate.named or not len(parameters):
                nuisance.append(Nuisance(candidate.joint, candidate.columns(x)))
                torques.append((np.zeros(len(index)), np.zeros(len(found.x))))
                continue
            torque = candidate.columns(x.whole or x) @ parameters
            tau -= np.outer(torque, candidate.term().on(len(motion.joints)))
            torques.append((x.mean(torque), candidate.columns(found.x) @ parameters))
        system = whitened.system
        assumed = replace(assumed.having(basis=model), nuisance=tuple(nuisance))
        left = replace(motion, tau=tau)
        whitened = whiten(left, index, seconds, inputs, assumed, x, system, lagging=lags)
        if found.problem.samples.weight is not None:
            whitened = counting_less(whitened)
        whitened = replace(whitened, seconds=shortest_seconds(whitened))
        carried = Carried.of(found, model.terms, whitened)
        residual = whitened.residual if carried is None else carried.residual
        return cls(whitened, residual, found, carried, tuple(torques))

    def judged(
        self,
        parts: Sequence[tuple[int, Candidate]],
        share: Callable[[Inputs], Floats] | None = None,
    ) -> HoldOut:
        """Return how findings do together: the log Bayes factor with them, over that without.

        Args:
            parts: the number of each finding, and the finding.
            share: returns by how much the torque counts at each sample (S,); None is 1.
        """
        z = np.zeros_like(self.residual)
        for number, candidate in parts:
            here, there = self.taken[number]
            if share is not None:
                here, there = here * share(self.whitened.x), there * share(self.found.x)
            z += self._white(here, there, candidate)
        return _judged(self.whitened, self.residual, z)

    def rival(self, score: BayesFactor, number: int, instead_of: Candidate) -> Floats:
        """Return the log Bayes factor by block (B,) of a frozen rival instead of a finding."""
        w = self.residual + self._white(*self.taken[number], instead_of)
        z = self._white(*self._torques(score), score.candidate)
        return np.asarray(np.add.reduceat(z * (w - 0.5 * z), self.whitened.starts))

    def less(self, score: BayesFactor) -> "HoldOutMotion":
        """Return the same with one more torque subtracted, the last of those taken."""
        torques = self._torques(score)
        residual = self.residual - self._white(*torques, score.candidate)
        return replace(self, residual=residual, taken=(*self.taken, torques))

    def alone(self) -> "HoldOutMotion":
        """Return the same with the model's own effects, and no curve, fitted to this motion."""
        whitened = self.whitened.explaining(self.whitened.basis, ())
        return replace(self, whitened=whitened, residual=whitened.residual, carried=None)

    def _torques(self, score: BayesFactor) -> tuple[Floats, Floats]:
        here, there = (score.candidate.columns(one.x) for one in (self.whitened, self.found))
        return here @ score.coefficients, there @ score.coefficients

    def _white(self, here: Floats, there: Floats, candidate: Candidate) -> Floats:
        """Return the whitened and projected torque (S N,) of a finding, N·m on its joint.

        Args:
            here, there: (S,) on this motion, (S',) on that of the search.
        """
        z = _whitened(self.whitened, here, candidate)
        if self.carried is None:
            return np.asarray(self.whitened.project(z[:, None])[:, 0])
        return self.carried.white(z, _whitened(self.found, there, candidate))


def _whitened(whitened: Whitened, torque: Floats, candidate: Candidate) -> Floats:
    """Return the whitened torque (S N,) of a finding, (S,) N·m on its joint."""
    on = shares(whitened.joints, candidate.joint, candidate.others)[None]
    return whitened.shared(torque[:, None], on)[:, 0]


def judge_hold_out(
    found: Search, motion: Motion, change: Change | None
) -> Mapping[int, tuple[HoldOutMotion, HoldOut]]:
    """Return, by number of each named step, its hold-out and the motion it was judged on.

    First everything is frozen. Where an effect fails beside a smaller one that fails as well, it is
    judged again with the smaller one fitted to this motion: subtracting an effect that is absent
    spoils the residual and with it the larger effect.
    """
    whole = without(found, motion, change)
    named = [number for number, step in enumerate(found.steps) if step.named]
    views = {number: (whole, _of_step(found, whole, number)) for number in named}
    failed: dict[int, list[int]] = {}
    for number in sorted(named, key=lambda n: -found.steps[n].score.log_bf):
        if not views[number][1].holds:
            failed.setdefault(found.steps[number].score.candidate.joint, []).append(number)
    smaller = {number for on_joint in failed.values() for number in on_joint[1:]}
    if smaller:
        again = without(found, motion, change, smaller)
        for number, *others in failed.values():
            if others:
                views[number] = (again, _of_step(found, again, number))
    return views


def judge_lag(found: Search, motion: Motion) -> HoldOut:
    """Return how a lag of the torques does on hold-out motion, frozen, beside any hysteresis.

    Args:
        found: with a lag.  motion: its torques are earlier by that lag.
    """
    assert found.lag is not None
    left = without(found, motion, None).whitened
    z, residual = column_of(left, hysteresis_of(left))
    return _judged(left, residual, found.lag.delay * z)


def without(
    found: Search, motion: Motion, change: Change | None, fitted: Collection[int] = ()
) -> HoldOutMotion:
    """Return hold-out motion with all findings subtracted.

    The steps whose numbers are in `fitted` stay free.
    """
    model = Basis(found.whitened.basis.terms[: found.own])
    parameters = (
        values[:0] if number in fitted else values
        for number, (values, _, _) in enumerate(frozen(found))
    )
    candidates = (step.score.candidate for step in found.steps)
    taken = list(zip(candidates, parameters, strict=True))
    return HoldOutMotion.of(motion, found.whitened, model, taken, change)


def frozen(found: Search) -> list[tuple[Floats, Floats, Floats]]:
    """Return each step's parameters, and the ends of their 90 % intervals, fitted together.

    The parameters belong to the shapes that were found; the intervals allow for wrong ones.
    """
    whitened = found.whitened
    places = [place for _, place in whitened.basis.slices()][found.own :]
    half = reach_of_all(whitened)
    values = Fitted.of(whitened).holding(whitened.basis.terms[found.own :]).values
    out = []
    waiting = iter(places)
    for step in found.steps:
        if not step.named:
            empty = np.zeros(0)
            out.append((empty, empty, empty))
            continue
        place = next(waiting)
        out.append((values[place], values[place] - half[place], values[place] + half[place]))
    return out


def _of_step(found: Search, motion: HoldOutMotion, number: int) -> HoldOut:
    """Return how a step does, beside hysteresis of its joint away from reversals as well.

    What hysteresis is not quite like in form is left near reversals, at low speed, and looks like
    friction over speed, or like a delay; but these are there wherever the joint is slow, and
    wherever the torque changes.
    """
    held = _alone_or_together(found, motion, number)
    candidate = found.steps[number].score.candidate
    effect, joint = candidate.effect, candidate.joint
    late = effect.kind == "measurement" and effect.coordinate == "since_reversal"
    if not held.holds or not (late or bends_over_speed(effect)):
        return held
    terms = (term for term in found.whitened.basis.terms if term.joint == joint)
    reach = max((term.effect.reach(term.shape) for term in terms), default=0.0)
    if reach <= 0.0:
        return held

    def far(x: Inputs) -> Floats:
        whole = x.whole or x
        beyond = travelled(whole.q[:, joint], whole.qd[:, joint], whole.segment) > BEYOND * reach
        return x.mean(beyond.astype(np.float64))

    away = motion.judged([(number, candidate)], far)
    if away.holds:
        return held
    words = (
        "it shows only where the joint has just reversed, as what is left of hysteresis does: "
        f"{'swing fast, then slowly' if late else 'creep without reversing'}"
    )
    return replace(held, doubt=Doubt(Reason.NEAR_REVERSALS, words))


def _alone_or_together(found: Search, motion: HoldOutMotion, number: int) -> HoldOut:
    """Return how a step does alone, or else with the steps of the same cause on other joints."""
    candidate = found.steps[number].score.candidate
    alone = motion.judged([(number, candidate)])
    same = [
        (n, other.score.candidate)
        for n, other in enumerate(found.steps)
        if other.named and other.score.candidate.cause == candidate.cause
    ]
    together = motion.judged(same) if len(same) > 1 and not alone.holds else alone
    return together if together.holds else alone


def _judged(whitened: Whitened, residual: Floats, z: Floats) -> HoldOut:
    """Return how effects with the whitened torque z (S N,) do on hold-out motion.

    Args:
        residual: (S N,) that they leave.
    """
    limits = thresholds.USED
    w = residual + z
    gained = np.add.reduceat(z * (w - 0.5 * z), whitened.starts)
    expected = np.add.reduceat(0.5 * z * z, whitened.starts)
    enough = min(len(expected), float(expected.sum()) / limits.group_nats[0]) / limits.fewest_groups
    power = float(z @ z)
    ratio = float(z @ w) / power if power > 0.0 else 0.0
    gained, expected = grouped(gained, expected)
    if len(gained) < limits.fewest_groups:
        lasts = recorded_seconds(whitened.motion.time, whitened.motion.segment)
        more = lasts / max(enough, 1e-9) - lasts
        wanted = f": {more:.0f} s more of it would do" if 1.0 < more < MOST_MORE else ""
        words = f"the unseen motion is too short, or hardly shows the effect, to confirm it{wanted}"
        return HoldOut(expected, gained, ratio, 1.0, Doubt(Reason.TOO_SHORT, words))
    p_value = signed_ranks(gained)
    share = float(np.mean(gained > 0.0))
    doubt = None
    if share < limits.held_out_share or p_value > limits.level:
        words = f"it helps in {share:.0%} of the unseen motion (p = {p_value:.2g}), too little"
        doubt = Doubt(Reason.NOT_HELD_OUT, words)
    elif not limits.size_ratio[0] < ratio < limits.size_ratio[1]:
        words = f"on the unseen motion it is {ratio:.2g} times as large: not the same effect"
        doubt = Doubt(Reason.OTHER_SIZE, words)
    return HoldOut(expected, gained, ratio, p_value, doubt)


def signed_ranks(gained: Floats) -> float:
    """Return the p-value of Wilcoxon's signed-rank test (1945), exactly.

    Args:
        gained: (G,) nats of a few groups: all 2ᴳ signs are tried.
    """
    rank = 1.0 + np.argsort(np.argsort(np.abs(gained)))
    above = ((np.arange(2 ** len(gained))[:, None] >> np.arange(len(gained))) & 1) @ rank
    return float(np.mean(above >= rank[gained > 0.0].sum()))


def grouped(gained: Floats, expected: Floats) -> tuple[Floats, Floats]:
    """Return the sums over groups of neighbouring blocks, with enough expected of each group.

    Groups are as alike as may be: of an effect that shows mostly in a few blocks, those of the
    others become smaller until there are enough of them, or too little is expected of each.
    """
    limits = thresholds.USED
    total = float(expected.sum())
    least = float(np.clip(total / limits.groups, *limits.group_nats))
    wanted = max(least, total / limits.most_groups)
    while True:
        groups = _groups(gained, expected, wanted)
        if len(groups[0]) >= limits.fewest_groups or wanted <= least:
            return groups
        wanted = max(least, 0.5 * wanted)


def _groups(gained: Floats, expected: Floats, least: float) -> tuple[Floats, Floats]:
    """Return the sums over groups of which `least` nats are expected, in the mean.

    Blocks stay whole: what exceeds the share of one group counts for the next. The last group has
    all that remains.
    """
    limits = thresholds.USED
    fewest = max(limits.group_nats[0], 0.5 * least)
    groups: list[float] = []
    hoped: list[float] = []
    sums, reached = np.zeros(2), 0.0
    for one, hope in zip(gained, expected, strict=True):
        sums += (one, hope)
        reached += hope
        # Rounding may keep the last group just below the total.
        enough = sums[1] >= fewest and reached >= (1.0 - ROUNDING) * (len(groups) + 1) * least
        if enough and len(groups) < limits.most_groups:
            groups.append(sums[0])
            hoped.append(sums[1])
            sums = np.zeros(2)
    if groups:
        groups[-1] += sums[0]
        hoped[-1] += sums[1]
    return np.array(groups), np.array(hoped)
