"""The hold-out: frozen findings judged on motion that the search did not use."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.intervals import reach_of_all
from lagrangian_ff.diagnosis.results import Change, Doubt, HoldOut, Reason
from lagrangian_ff.diagnosis.search.bayes_factor import BayesFactor
from lagrangian_ff.diagnosis.search.candidates import Candidate, bends_over_speed
from lagrangian_ff.diagnosis.search.fitted import Fitted
from lagrangian_ff.diagnosis.search.forward import Search
from lagrangian_ff.diagnosis.whitening import Whitened, counting_less, whiten
from lagrangian_ff.diagnosis.whitening.blocks import shortest_seconds
from lagrangian_ff.diagnosis.whitening.hyperparameters import used
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
        whitened: the motion; its residual has every frozen finding subtracted.
        torques: for each finding, its torque (S,) N·m at the samples used.
    """

    whitened: Whitened
    torques: tuple[Floats, ...]

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
            model: the basis of the model, its shapes fitted; its parameters stay free.
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
        whitened = whiten(motion, index, seconds, found.inputs_of(motion), assumed)
        inputs = whitened.inputs_of(motion)
        x = replace(whitened, inputs=inputs).inputs_left_out()
        tau = motion.tau.copy()
        torques, nuisance = [], []
        for candidate, parameters in taken:
            if not candidate.named or not len(parameters):
                nuisance.append(Nuisance(candidate.joint, candidate.columns(x)))
                torques.append(np.zeros(len(index)))
                continue
            torque = candidate.columns(x.whole or x) @ parameters
            tau -= np.outer(torque, candidate.term().on(len(motion.joints)))
            torques.append(x.mean(torque))
        system = whitened.system
        assumed = replace(assumed.having(basis=model), nuisance=tuple(nuisance))
        left = replace(motion, tau=tau)
        whitened = whiten(left, index, seconds, inputs, assumed, x, system)
        if found.problem.samples.weight is not None:
            whitened = counting_less(whitened)
        return cls(replace(whitened, seconds=shortest_seconds(whitened)), tuple(torques))

    def judged(
        self, parts: Sequence[tuple[int, Candidate]], share: Floats | None = None
    ) -> HoldOut:
        """Return how findings do together: the log Bayes factor with them, over that without.

        Args:
            parts: the number of each finding, and the finding.
            share: (S,) by which the torque counts at each sample; None is 1.
        """
        z = np.zeros_like(self.whitened.residual)
        for number, candidate in parts:
            torque = self.torques[number]
            z += self._white(torque if share is None else torque * share, candidate)
        return _judged(self.whitened, z)

    def _white(self, torque: Floats, candidate: Candidate) -> Floats:
        """Return the whitened and projected torque (S N,) of a finding, (S,) N·m on its joint."""
        on = shares(self.whitened.joints, candidate.joint, candidate.others)[None]
        return self.whitened.project(self.whitened.shared(torque[:, None], on))[:, 0]

    def rival(self, score: BayesFactor, number: int, instead_of: Candidate) -> Floats:
        """Return the log Bayes factor by block (B,) of a frozen rival instead of a finding."""
        whitened, candidate = self.whitened, score.candidate
        w = whitened.residual + self._white(self.torques[number], instead_of)
        z = self._white(candidate.columns(whitened.x) @ score.coefficients, candidate)
        return np.asarray(np.add.reduceat(z * (w - 0.5 * z), whitened.starts))


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


def without(
    found: Search, motion: Motion, change: Change | None, fitted: Collection[int] = ()
) -> HoldOutMotion:
    """Return hold-out motion with all findings subtracted.

    The model's own effects stay free, and so do the steps whose numbers are in `fitted`.
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
    x = motion.whitened.inputs
    far = travelled(x.q[:, joint], x.qd[:, joint], x.segment) > BEYOND * reach
    away = motion.judged([(number, candidate)], motion.whitened.x.mean(far.astype(np.float64)))
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


def _judged(whitened: Whitened, z: Floats) -> HoldOut:
    """Return how effects with the whitened torque z (S N,) do on hold-out motion."""
    limits = thresholds.USED
    w = whitened.residual + z
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
