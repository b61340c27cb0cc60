"""The hold-out: frozen findings judged on motion that the search did not use."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.results import Change, Doubt, HoldOut, Reason
from lagrangian_ff.diagnosis.search.bayes_factor import BayesFactor
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.diagnosis.search.forward import Search
from lagrangian_ff.diagnosis.whitening import Whitened, whiten
from lagrangian_ff.diagnosis.whitening.hyperparameters import BLOCK_SECONDS
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.problem import Nuisance
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.recording.motion import Motion

ROUNDING = 1e-9


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
        index = evenly(len(motion), thresholds.EFFORT.rows // len(motion.joints))
        block = motion.blocks(BLOCK_SECONDS)[index]
        whole = Basis((*model.terms, *(c.term() for c, b in taken if c.named and len(b))))
        assumed = replace(assumed.having(basis=whole), nuisance=())
        whitened = whiten(motion, index, block, found.inputs_of(motion), assumed)
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
            tau[:, candidate.joint] -= torque
            torques.append(x.mean(torque))
        system = whitened.system
        assumed = replace(assumed.having(basis=model), nuisance=tuple(nuisance))
        left = replace(motion, tau=tau)
        whitened = whiten(left, index, block, inputs, assumed, x, system)
        return cls(whitened, tuple(torques))

    def judged(self, parts: Sequence[tuple[int, int]]) -> HoldOut:
        """Return how findings do together: the log Bayes factor with them, over that without.

        Args:
            parts: the number of each finding, and its joint.
        """
        whitened = self.whitened
        z = np.zeros_like(whitened.residual)
        for number, joint in parts:
            z += whitened.project(whitened.whitened(self.torques[number][:, None], joint))[:, 0]
        return _judged(whitened, z)

    def rival(self, score: BayesFactor, instead_of: int) -> Floats:
        """Return the log Bayes factor by block (B,) of a frozen rival instead of a finding."""
        whitened, candidate = self.whitened, score.candidate
        joint = candidate.joint
        back = whitened.project(whitened.whitened(self.torques[instead_of][:, None], joint))[:, 0]
        torque = candidate.columns(whitened.x) @ score.coefficients
        z = whitened.project(whitened.whitened(torque[:, None], joint))[:, 0]
        w = whitened.residual + back
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
    views = {number: (whole, _alone_or_together(found, whole, number)) for number in named}
    failed: dict[int, list[int]] = {}
    for number in sorted(named, key=lambda n: -found.steps[n].score.log_bf):
        if not views[number][1].holds:
            failed.setdefault(found.steps[number].score.candidate.joint, []).append(number)
    smaller = {number for on_joint in failed.values() for number in on_joint[1:]}
    if smaller:
        again = without(found, motion, change, smaller)
        for number, *others in failed.values():
            if others:
                views[number] = (again, _alone_or_together(found, again, number))
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
    """Return each step's parameters, and the ends of their 90 % intervals, fitted together."""
    whitened = found.whitened
    places = [place for _, place in whitened.basis.slices()][found.own :]
    values = whitened.system.coefficients
    deviation = whitened.system.deviations
    out = []
    waiting = iter(places)
    for step in found.steps:
        if not step.named:
            empty = np.zeros(0)
            out.append((empty, empty, empty))
            continue
        place = next(waiting)
        reach = 1.645 * np.sqrt(step.score.variance_inflation) * deviation[place]
        out.append((values[place], values[place] - reach, values[place] + reach))
    return out


def _alone_or_together(found: Search, motion: HoldOutMotion, number: int) -> HoldOut:
    """Return how a step does alone, or else with the steps of the same cause on other joints."""
    candidate = found.steps[number].score.candidate
    alone = motion.judged([(number, candidate.joint)])
    same = [
        (n, other.score.candidate.joint)
        for n, other in enumerate(found.steps)
        if other.named and other.score.candidate.cause == candidate.cause
    ]
    together = motion.judged(same) if len(same) > 1 and not alone.holds else alone
    return together if together.holds else alone


def _judged(whitened: Whitened, z: Floats) -> HoldOut:
    """Return how effects with the whitened torque z (S N,) do on hold-out motion."""
    limits = thresholds.USED
    w = whitened.residual + z
    gained = _by_piece(whitened, z * (w - 0.5 * z))
    expected = _by_piece(whitened, 0.5 * z * z)
    power = float(z @ z)
    ratio = float(z @ w) / power if power > 0.0 else 0.0
    gained, expected = grouped(gained, expected)
    if len(gained) < limits.fewest_groups:
        words = "the unseen motion is too short, or hardly shows the effect, to confirm it"
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


def _by_piece(whitened: Whitened, values: Floats) -> Floats:
    """Return the sums of values (S N,) over pieces of time within blocks."""
    time = whitened.x.time
    piece = np.floor(time / thresholds.USED.piece) if np.isfinite(time).all() else 0.0
    changes = np.diff(whitened.block) != 0
    changes |= np.diff(np.broadcast_to(piece, len(whitened.block))) != 0.0
    starts = np.concatenate([[0], np.flatnonzero(changes) + 1]) * whitened.joints
    return np.asarray(np.add.reduceat(values, starts))


def grouped(gained: Floats, expected: Floats) -> tuple[Floats, Floats]:
    """Return the sums over groups of neighbouring pieces, with enough expected of each group.

    Pieces stay whole: what exceeds the share of one group counts for the next.
    """
    limits = thresholds.USED
    total = float(expected.sum())
    least = float(np.clip(total / limits.groups, *limits.group_nats))
    least = max(least, total / limits.most_groups)
    fewest = max(limits.group_nats[0], 0.5 * least)
    groups: list[float] = []
    hoped: list[float] = []
    sums, reached = np.zeros(2), 0.0
    for one, hope in zip(gained, expected, strict=True):
        sums += (one, hope)
        reached += hope
        # Rounding may keep the last group just below the total.
        if sums[1] >= fewest and reached >= (1.0 - ROUNDING) * (len(groups) + 1) * least:
            groups.append(sums[0])
            hoped.append(sums[1])
            sums = np.zeros(2)
    if groups:
        groups[-1] += sums[0]
        hoped[-1] += sums[1]
    return np.array(groups), np.array(hoped)
