"""Forward search: find the best candidate, explain it, refit, look again; backward in the end.

The same Bayes factors show which effects the motion could not have shown.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.lag import Lag
from lagrangian_ff.diagnosis.results import Change, NotObservable
from lagrangian_ff.diagnosis.search.backward import (
    backward,
    basis_without,
    judged_again,
    reconsidered,
)
from lagrangian_ff.diagnosis.search.bayes_factor import BayesFactor, bayes_factors
from lagrangian_ff.diagnosis.search.candidates import bends_over_speed
from lagrangian_ff.diagnosis.search.change import change_of
from lagrangian_ff.diagnosis.search.judging import (
    Step,
    bare,
    candidates_of,
    causes_of,
    explained_with,
    judge,
    judge_alike,
    possible,
)
from lagrangian_ff.diagnosis.search.lag import hysteresis_of, lag_of, set_right
from lagrangian_ff.diagnosis.search.significance import MaximumNull, best_of_each
from lagrangian_ff.diagnosis.search.visible import clearest, hidden, still
from lagrangian_ff.diagnosis.whitening import Whitened, outweighed, refit
from lagrangian_ff.diagnosis.whitening.blocks import MANY, block_seconds
from lagrangian_ff.diagnosis.whitening.hyperparameters import with_sign_speeds
from lagrangian_ff.effects import EFFECTS, Effect
from lagrangian_ff.identification.problem import Nuisance
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.motion import LONGEST_DELAY
from lagrangian_ff.sampling import recorded_seconds

MOST_STEPS = 40
"""More than any arm lacks: the search ends where nothing stands out."""
TRIED = 3
"""Joints whose best candidate is judged, until one holds; looks at one bend beside other widths."""
AGAIN = 1.5
"""Ratio of its gain to that at its rejection from which on a joint is judged again."""
KEEPS = 0.5
"""Share of its gain that a bend over speed keeps beside other widths, or the search looks again."""
SHORTER = 0.8
"""Ratio of the lengths of blocks below which all candidates are judged again."""


@dataclass(frozen=True)
class Search:
    """The search on one whitened motion.

    Attributes:
        steps: what was found, in order.
        all: all candidates at all shapes, scored before the first step.
        ranking: of these, each candidate at its best shape, best first.
        last: the same after the last step, when nothing stood out any more.
        null: of the maximum, before the first step.
        change: a load that was taken up on the way, if any.
        whitened: the motion, with all steps explained.
        own: the number of terms that the basis had before the first step.
        wanting: s of such motion that a verdict needs besides; without it there are no steps.
        lag: of the torques, which `whitened` has set right; None if they show none. The search
            ends with it: what was found before has a form that makes up for the lag.
    """

    steps: tuple[Step, ...]
    all: tuple[BayesFactor, ...]
    ranking: tuple[BayesFactor, ...]
    last: tuple[BayesFactor, ...]
    null: MaximumNull
    change: Change | None
    whitened: Whitened
    own: int
    wanting: float = 0.0
    lag: Lag | None = None

    def without_curves(self, curves: Sequence[Step]) -> tuple[Nuisance, ...]:
        """Return the columns of all curves but some, which are steps of the search."""
        every = [step for step in self.steps if not step.named]
        pairs = zip(self.whitened.problem.nuisance, every, strict=True)
        return tuple(one for one, of in pairs if not any(of is curve for curve in curves))


def search(
    whitened: Whitened,
    effects: Mapping[str, Effect] | None = None,
    steps: int = MOST_STEPS,
    progress: Progress = silent,
    known: int = 0,
    lagging: bool = True,
) -> Search:
    """Return the search, which takes one step after the other until nothing stands out.

    Args:
        whitened: the motion, with the model's effects, and with those known of other motion.
        effects: those that may be missing; None takes the catalogue.
        steps: the largest number of steps.
        progress: receives the share done, 0 to 1.
        known: the number of effects that are known of other motion, the last ones: they are steps
            like those that are found, and judged again beside them.
        lagging: whether a lag of the torques is looked for.
    """
    own = len(whitened.basis.terms) - known
    way = _Forward(effects, steps, own, progress, lagging)
    whitened = way.go(whitened)
    if way.lag is None:
        way.taken, whitened = backward(way.taken, whitened, own)
        way.taken, whitened = reconsidered(way.taken, whitened, own, effects)
    ended = way.lag or way.wanting or len(way.taken) >= steps
    lighter = None if ended else outweighed(whitened)
    if lighter is not None:
        way.late = True
        before = len(way.taken)
        lighter = way.go(lighter)
        if len(way.taken) > before:
            way.taken, lighter = backward(way.taken, lighter, own, before)
            way.taken, whitened = reconsidered(way.taken, lighter, own, effects, before)
    (every, ranking, null), (_, last, _) = way.rounds[0], way.rounds[-1]
    return Search(
        tuple(way.taken),
        tuple(every),
        tuple(ranking),
        tuple(last),
        null,
        way.change,
        whitened,
        own,
        way.wanting,
        way.lag,
    )


class _Forward:
    """The way forward, step by step.

    Attributes:
        taken: the steps so far.
        change: a load that was taken up on the way, if any.
        rounds: of each look all candidates, each at its best shape, and the null.
        wanting: see `Search`.
        late: whether outliers count less by now.
        lag: of the torques, if they were set right.
    """

    def __init__(
        self,
        effects: Mapping[str, Effect] | None,
        steps: int,
        own: int,
        progress: Progress,
        lagging: bool,
    ) -> None:
        self.taken: list[Step] = []
        self.change: Change | None = None
        self.rounds: list[tuple[list[BayesFactor], list[BayesFactor], MaximumNull]] = []
        self.wanting = 0.0
        self.late = False
        self.lag: Lag | None = None
        self._lagging = lagging and "delay" in (effects or EFFECTS)
        self._bent: Counter[tuple[str, int]] = Counter()
        self._effects, self._steps, self._own, self._progress = effects, steps, own, progress

    def go(self, whitened: Whitened) -> Whitened:
        """Take steps until nothing stands out; return the motion with all of them explained."""
        effects, steps = self._effects, self._steps
        rejected: dict[int, float] = {}
        stands = still(whitened.motion)
        while True:
            whitened, found = self._scores(whitened)
            causes = causes_of(whitened.basis)
            # Static friction of a joint at rest has any form.
            moving = [one for one in found if not stands[one.candidate.joint]]
            best = best_of_each(moving, causes)
            null = MaximumNull.of([score for score in moving if not score.once])
            self.rounds.append((found, best, null))
            if len(self.rounds) == 1:
                known = len(whitened.basis.terms) - self._own
                self.taken, whitened = judged_again(whitened, self._own, null, effects)
                if len(self.taken) < known:
                    continue  # all others are to be compared with less now
            able = [score for score in best if possible(score, causes, whitened.x)]
            near = [score for score in able if _stands_out(score, null, whitened, nearly=True)]
            eligible = [score for score in near if _stands_out(score, null, whitened)]
            self.wanting = _wanting(whitened)
            if self.wanting:
                return whitened
            if (in_step := self._set_right(whitened, eligible)) is not None:
                return in_step
            if (changed := self._changed(whitened, eligible)) is not None:
                whitened = changed
                continue
            if len(self.taken) >= steps:
                return whitened
            step = None
            for first in _of_each_joint(near, rejected):
                name = first.candidate.source.name
                self._say(f"looking closer at {name}", 0.5)
                step, refitted = judge(whitened, first, best, null, effects)
                if step is not None:
                    break
                rejected[first.candidate.joint] = first.log_bf
            if step is None:
                return whitened
            if (otherwise := self._with_other_widths(refitted, step)) is not None:
                whitened = otherwise
                continue
            self.taken.append(replace(step, late=self.late))
            whitened = refitted.explaining(*explained_with(whitened, step.score.candidate))
            if step.named and len(self.taken) < steps:
                alike, whitened = judge_alike(whitened, step, eligible, null, effects)
                self.taken += [replace(one, late=self.late) for one in alike]
                if step.score.candidate.effect.kind == "friction":
                    whitened = with_sign_speeds(whitened, range(whitened.joints))

    def _with_other_widths(self, refitted: Whitened, step: Step) -> Whitened | None:
        """Return the motion with other widths of Coulomb steps, if they do for a bend over speed.

        A width was fitted while more was missing and the noise was larger.

        Args:
            refitted: the motion with the noise that suits the step, without it.
        """
        candidate = step.score.candidate
        bends = step.named and bends_over_speed(candidate.effect)
        if not bends or self._bent[candidate.key] >= TRIED:
            return None
        self._bent[candidate.key] += 1
        otherwise = with_sign_speeds(refitted, {candidate.joint})
        before, after = (bayes_factors(one, [candidate])[0] for one in (refitted, otherwise))
        return otherwise if after.log_bf < KEEPS * before.log_bf else None

    def _scores(self, whitened: Whitened) -> tuple[Whitened, list[BayesFactor]]:
        """Return the motion, its blocks as short as may be, and all candidates scored."""
        self._say(f"looking at every effect, step {len(self.rounds) + 1}", 0.0, more=1)
        candidates = candidates_of(whitened, range(whitened.joints), self._effects)
        found = bayes_factors(whitened, candidates, coarse=True)
        whitened.forget()
        if not self.rounds and found and len(np.unique(whitened.block)) < MANY:
            shorter = _with_blocks(whitened, max(found, key=lambda score: score.log_bf))
            if shorter.seconds < SHORTER * whitened.seconds:
                whitened = shorter
                found = bayes_factors(whitened, candidates, coarse=True)
                whitened.forget()
        return whitened, found

    def _set_right(self, whitened: Whitened, eligible: Sequence[BayesFactor]) -> Whitened | None:
        """Return the motion with its torques in step; None if no lag explains more than these."""
        if not self._lagging:
            return None
        best = max((score.log_bf for score in eligible), default=0.0)
        floor = thresholds.USED.floor
        if lag_of(whitened).log_bayes_factor <= max(best, floor):
            return None
        beside = hysteresis_of(whitened)
        if lag_of(whitened, beside).log_bayes_factor <= floor:
            return None
        moved, lag = set_right(whitened, beside)
        if abs(lag.delay) > LONGEST_DELAY:
            return None
        self.lag = lag
        return moved

    def _changed(self, whitened: Whitened, eligible: Sequence[BayesFactor]) -> Whitened | None:
        """Return the motion with a load that is taken up on the way; None if there is none."""
        every = (self._effects or EFFECTS).values()
        may = self.change is None and any(one.arm_event == "lasting" for one in every)
        if not may or (self.taken and eligible):
            return None
        change = change_of(whitened)
        if change is None or change.log_bayes_factor <= _to_beat(whitened, eligible):
            return None
        self.change = change
        nuisance = whitened.problem.nuisance
        return whitened.assuming(refit(whitened, whitened.basis, nuisance, change.prior))

    def _say(self, what: str, share: float, more: int = 0) -> None:
        """Tell the progress: each look takes a quarter of what is left."""
        looks = len(self.rounds) - 1 + more
        self._progress(1.0 - 0.75**looks + share * 0.25 * 0.75**looks, what)


def _of_each_joint(near: Sequence[BayesFactor], rejected: Mapping[int, float]) -> list[BayesFactor]:
    """Return the best of each joint, `TRIED` at most: hyperparameters may explain the first.

    Args:
        rejected: nats of the best of a joint when it was rejected; it must gain clearly more now.
    """
    first: dict[int, BayesFactor] = {}
    for score in near:
        first.setdefault(score.candidate.joint, score)
    better = [one for n, one in first.items() if one.log_bf > AGAIN * rejected.get(n, 0.0)]
    return better[:TRIED]


def _with_blocks(whitened: Whitened, best: BayesFactor) -> Whitened:
    """Return the motion with blocks as short as its noise allows.

    What is missing lengthens the memory of the residual, which is measured without the best
    candidate.
    """
    without = whitened.explaining(*explained_with(whitened, best.candidate))
    return replace(whitened, seconds=block_seconds(without))


def _wanting(whitened: Whitened) -> float:
    """Return the s of such motion that a verdict needs besides; 0 if there is enough."""
    blocks = len(np.unique(whitened.block))
    motion = whitened.motion
    lasts = recorded_seconds(motion.time, motion.segment)
    return max(0.0, (thresholds.USED.fewest_blocks / blocks - 1.0) * lasts)


def beside_others(found: Search, step: Step) -> float:
    """Return the log Bayes factor of a step beside all others, with the noise that is left.

    A step's own score has the noise of its time, which falls with each later step.
    """
    whitened, nuisance = found.whitened, found.whitened.problem.nuisance
    basis = whitened.basis
    if step.named:
        basis = basis_without(basis, found.own, step.score.candidate)
    else:
        nuisance = found.without_curves([step])
    less = whitened.explaining(basis, nuisance)
    (score,) = bayes_factors(less, [step.score.candidate])
    less.forget()
    return score.log_bf


def _stands_out(
    score: BayesFactor, null: MaximumNull, whitened: Whitened, *, nearly: bool = False
) -> bool:
    """Return whether a score is large enough to be claimed.

    Args:
        nearly: whether a smaller score will do, which may grow with hyperparameters that suit it.
            Those that were fitted without it explain a part of it, or call it noise.
    """
    limits = thresholds.USED
    if score.size <= limits.least_size * whitened.spread[score.candidate.joint]:
        return False
    if score.once:
        return score.log_bf > limits.event_floor
    floor = limits.floor * (limits.near_floor if nearly else 1.0)
    return score.log_bf > floor and null.exceeded_by(score.log_bf)


def _to_beat(whitened: Whitened, eligible: Sequence[BayesFactor]) -> float:
    """Return the nats that a change of the whole arm must exceed to come before these scores.

    Where friction is missing altogether, a second Lagrangian takes up much of it.
    """
    without = any(bare(whitened, score.candidate.joint) for score in eligible)
    factor = thresholds.USED.bare_factor if without else 1.0
    return factor * max((score.log_bf for score in eligible), default=0.0)


def not_observable(found: Search, joints: Sequence[str]) -> tuple[NotObservable, ...]:
    """Return the effects, joint by joint, that this motion hides."""
    present = {step.score.candidate.key for step in found.steps}
    # The last have the noise that is left beside all that was found.
    every = [one for one in (*found.all, *found.last) if one.candidate.key not in present]
    return hidden(clearest(every), found.whitened.motion, joints)
