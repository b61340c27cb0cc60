"""The way uphill: from templates to the control points of the motion that says most."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis.excite.keeping import Keeper
from lagrangian_ff.diagnosis.excite.objective import Objective
from lagrangian_ff.diagnosis.excite.splines import AT_REST, Splines
from lagrangian_ff.diagnosis.excite.starts import starts_of
from lagrangian_ff.errors import ModelError
from lagrangian_ff.progress import Progress

FEWEST, MOST = 60, 300
"""Samples that the search looks at, at least and at most."""
SMALLER = 0.95
"""Share of the way from the start that is left where a motion keeps the limits at no tempo."""
LEAST = 0.1
"""rad, a joint that would move less is held."""
USUAL_STARTS = 40
"""Their usual number."""


class _SpentError(Exception):
    """All looks are spent; one step of L-BFGS-B may take twenty."""


@dataclass(frozen=True)
class Effort:
    """The length of the search.

    Attributes:
        rows: torques that it looks at.
        starts: that are climbed from.  first: looks on the way up from each.
        rounds: then from the better one: looks, and the weight of the excess over limits against
            the log of nats.
    """

    rows: int = 900
    starts: int = 2
    first: int = 10
    rounds: tuple[tuple[int, float], ...] = ((12, 30.0), (12, 100.0), (10, 1e3), (10, 1e4))

    def scaled(self, share: float) -> "Effort":
        """Return a share of this effort, at least one look at each place."""
        rounds = tuple((max(1, round(share * count)), hard) for count, hard in self.rounds)
        return replace(self, first=max(1, round(share * self.first)), rounds=rounds)

    @property
    def looks(self) -> int:
        """Return how often a motion is looked at on one way."""
        return self.starts * self.first + sum(count for count, _ in self.rounds)


USUAL = Effort()


@dataclass(frozen=True)
class Found:
    """Control points (K, N) of a clear motion.

    Attributes:
        value: the log of the nats in it, less the weighed excess over limits.
        begun: the motion that it was climbed from.
        looks: that it took to come here.
    """

    control: Floats
    value: float
    begun: str
    looks: int = 0


@dataclass(frozen=True)
class Way:
    """A way uphill: which joints move, and what is assumed of the arm.

    Attributes:
        pose: (N,) rad, where the motion begins and ends.
        free: the joints that may move.
    """

    objective: Objective
    keeper: Keeper
    pose: Floats
    effort: Effort
    free: tuple[int, ...]

    @property
    def splines(self) -> Splines:
        """Return the motions that are searched."""
        return self.objective.splines

    def on_other_samples(self, seed: int) -> "Way":
        """Return the way with other samples: a motion must not suit some of them alone."""
        index = samples_of(self.splines, self.effort, len(self.pose), seed)
        return replace(self, objective=replace(self.objective, index=index))

    def starts(self, wanted: Sequence[str], seed: int, progress: Progress) -> list[Found]:
        """Return motions to climb from, best first.

        Raises:
            ModelError: none is clear.
        """
        limits, splines = self.keeper.limits, self.splines
        still = np.tile(self.pose, (splines.count, 1))
        found = []
        every = starts_of(
            self.keeper.model.joints, wanted, limits, self.pose, splines.seconds, seed
        )
        for number, (name, q) in enumerate(every):
            progress(min(1.0, number / USUAL_STARTS), "looking at the templates")
            near = np.clip(splines.nearest(q, self.pose), limits.q_low, limits.q_high)
            control = self.keeper.cleared(splines, near, still)
            if control is not None:
                found.append(Found(control, self._value(control), name))
        if not found:
            raise ModelError("no motion from the start is clear: name another, or fewer obstacles")
        return sorted(found, key=lambda one: -one.value)

    def alone(
        self, joints: Sequence[int], found: Sequence[Found]
    ) -> "tuple[Way, list[Found]] | None":
        """Return the way on which only some joints move, and its starts, best first.

        The search knows an arm the better, the less it has moved: kernel and noise are fitted to
        the best of these starts. None if all joints are asked for, or no start holds the others.
        """
        others = [n for n in range(len(self.pose)) if n not in joints]
        held = [one for one in found if not np.ptp(one.control[:, others], axis=0).any()]
        if not others or not held:
            return None
        suited = self.objective.assumed.suited_to(self.splines.reference(held[0].control))
        objective = replace(self.objective, assumed=suited)
        way = replace(self, objective=objective, free=tuple(joints))
        again = [replace(one, value=way._value(one.control)) for one in held]
        return way, sorted(again, key=lambda one: -one.value)

    def uphill(self, starts: Sequence[Found], seed: int) -> Iterator[Found]:
        """Yield the best motion so far, again and again."""
        best = starts[0]
        hard = self.effort.rounds[0][1]
        for one in starts[: self.effort.starts]:
            best = max(best, self._climbed(one, self.effort.first, hard), key=_worth)
            yield replace(best, looks=self.effort.first)
        for number, (looks, hard) in enumerate(self.effort.rounds, start=1):
            best = self.on_other_samples(seed + number)._climbed(best, looks, hard)
            yield best

    def _value(self, control: Floats, hard: float | None = None) -> float:
        hard = self.effort.rounds[0][1] if hard is None else hard
        look = self.objective.look(control, slope=False)
        return look.value - hard * self.keeper.penalty(self.splines, control)[0]

    def _climbed(self, begin: Found, looks: int, hard: float) -> Found:
        """Return the motion after some looks on the way uphill."""
        limits, splines, free = self.keeper.limits, self.splines, list(self.free)
        inner = np.ix_(range(AT_REST, splines.count - AT_REST), free)
        control = begin.control.copy()
        tried: list[tuple[float, Floats]] = []

        def down(z: Floats) -> tuple[float, Floats]:
            if len(tried) == looks:
                raise _SpentError
            control[inner] = z.reshape(-1, len(free))
            look = self.objective.look(control)
            slope = self.objective.slope(look, control, free)
            excess, by_control = self.keeper.penalty(splines, control)
            value = hard * excess - look.value
            tried.append((value, z.copy()))
            return value, (hard * by_control - slope)[inner].ravel()

        ends = zip(limits.q_low[free], limits.q_high[free], strict=True)
        with suppress(_SpentError):
            scipy.optimize.minimize(
                down,
                begin.control[inner].ravel(),
                jac=True,
                method="L-BFGS-B",
                bounds=list(ends) * (splines.count - 2 * AT_REST),
                options={"ftol": 1e-12, "gtol": 1e-9},
            )
        _, best = min(tried, key=lambda one: one[0])
        control[inner] = best.reshape(-1, len(free))
        clear = self.keeper.cleared(splines, control, begin.control)
        if clear is None:
            return replace(begin, looks=looks)
        return Found(clear, self._value(clear, hard), begin.begun, looks)

    def kept(self, found: Found) -> tuple[Splines, Floats] | None:
        """Return the splines and control points of a motion that keeps the limits.

        It is slowed down, and made smaller where that does not help. None if nothing helps, or
        hardly anything moves.
        """
        control = self._held(found.control)
        while np.ptp(control, axis=0).max() >= 0.05 * LEAST:
            if (splines := self.keeper.kept(self.splines, control)) is not None:
                return splines, control
            control = self.pose + SMALLER * (control - self.pose)
        return None

    def _held(self, control: Floats) -> Floats:
        """Return control points with joints held that hardly move, if the way is clear then.

        Static friction of a joint that creeps by some mrad has no form that a model knows. Where
        only the joints in question move, little motion is what was found best for them.
        """
        if len(self.free) < len(self.pose):
            return control
        held = control.copy()
        hardly = np.ptp(control, axis=0) < LEAST
        held[:, hardly] = self.pose[hardly]
        clear = self.keeper.cleared(self.splines, held, held)
        return control if clear is None else held


def samples_of(splines: Splines, effort: Effort, joints: int, seed: int) -> Ints:
    """Return (S,) samples to look at, one somewhere in each of as many even stretches."""
    count = int(np.clip(effort.rows // joints, FEWEST, MOST))
    place = np.arange(count) + np.random.default_rng(seed).uniform(size=count)
    return np.asarray(place * len(splines.time) / count, dtype=np.int64)


def _worth(found: Found) -> float:
    return found.value
