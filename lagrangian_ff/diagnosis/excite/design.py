"""A motion designed by its information: it is to show as much as the limits allow."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis.excite.assumed import SIZE, Assumed, Expected, representative
from lagrangian_ff.diagnosis.excite.excite import inside, seen_pose
from lagrangian_ff.diagnosis.excite.keeping import Clear, Keeper, limits_of
from lagrangian_ff.diagnosis.excite.objective import Objective, nats_of
from lagrangian_ff.diagnosis.excite.path import GRID, Limits, Reference
from lagrangian_ff.diagnosis.excite.questions import Everything, For, Question, cases_of
from lagrangian_ff.diagnosis.excite.splines import AT_REST, DEGREE, Splines
from lagrangian_ff.diagnosis.excite.starts import starts_of
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.threads import limited, one_blas_thread
from lagrangian_ff.progress import Progress, part, silent

SECONDS, SHORTEST, LONGEST = 20.0, 8.0, 60.0
SPACING = 0.2
"""s between the knots."""
FEWEST, MOST = 60, 300
"""Samples that the search looks at, at least and at most."""
SMALLER = 0.95
"""Share of the way from the start that is left where a motion keeps the limits at no tempo."""
LEAST = 0.05
"""rad, a joint that would move less is held."""


@dataclass(frozen=True)
class Effort:
    """How long the search goes on.

    Attributes:
        rows: torques that it looks at.
        starts: that are climbed from.  first: looks on the way up from each.
        rounds: then from the better one: looks, and the weight of the excess over limits against
            the log of nats.
    """

    rows: int = 900
    starts: int = 2
    first: int = 12
    rounds: tuple[tuple[int, float], ...] = (
        (15, 30.0), (15, 30.0), (15, 100.0), (12, 1e3), (12, 1e4)
    )  # fmt: skip

    def scaled(self, share: float) -> "Effort":
        """Return a share of this effort, at least one look at each place."""
        rounds = tuple((max(1, round(share * count)), hard) for count, hard in self.rounds)
        return replace(self, first=max(1, round(share * self.first)), rounds=rounds)


USUAL = Effort()


@dataclass(frozen=True)
class Design:
    """A designed motion.

    Attributes:
        question: that it is to answer.  joints: N names.
        reference: the motion, every 0.01 s.
        nats: expected to decide the question at the size asked for, the least of all ways to err.
        expected: of every effect on every joint at this size.
        used: by limit, (N,) the share of it that the motion takes.
        begun: the motion that it was climbed from.
        beyond: the joints that go where the model has not seen them, where it guesses.
        finished: whether the search went to its end.
    """

    question: Question
    joints: tuple[str, ...]
    reference: Reference
    nats: float
    expected: tuple[Expected, ...]
    used: Mapping[str, Floats]
    begun: str
    beyond: tuple[str, ...] = ()
    finished: bool = True


def design(
    model: Model,
    question: Question,
    limits: Limits | None = None,
    *,
    start: Floats | None = None,
    seconds: float = SECONDS,
    size: float = SIZE,
    clear: Clear | None = None,
    assumed: Assumed | None = None,
    effort: Effort = USUAL,
    seed: int = 0,
    progress: Progress = silent,
) -> Design:
    """Return the motion that is expected to say most about a question.

    Interrupted (KeyboardInterrupt), it returns the best motion that it has found.

    Args:
        limits: never left; None takes what the model's own data reached.
        start: (N,) rad, where it begins and ends; None takes a pose of those data.
        seconds: how long it lasts; a little longer where limits ask for it.
        size: of effects, see `Expected`.
        clear: says what touches on a path; None if nothing is known of that.
        assumed: of the model, if it is at hand.
        effort: how long the search goes on.
        seed: of what is random.
        progress: receives the share done, 0 to 1.

    Raises:
        ModelError: a question that no motion answers, no joint with room to move, a start outside
            the limits or not clear, or a duration or size that cannot be.
    """
    if not SHORTEST <= seconds <= LONGEST:
        raise ModelError(f"a duration of {seconds:g} s: expected {SHORTEST:g} to {LONGEST:g} s")
    if not 0.0 < size <= 1.0:
        raise ModelError(f"a size of {size:g}: expected more than 0, and 1 at most")
    limits = limits_of(model) if limits is None else limits
    assumed = Assumed.of(model, part(progress, 0.0, 0.15)) if assumed is None else assumed
    pose = pose_for(question, model, limits) if start is None else start
    pose = inside("start", pose, model.joints, limits)
    keeper = Keeper(model, limits, 2.0 * assumed.base.noise, clear)
    if clear is not None and (touch := clear(pose[None, :])):
        raise ModelError(f"the motion would begin where {touch} touch: name another start")
    search = _Search.of(assumed, question, keeper, pose, seconds, size, effort, seed)
    # Threads that share products as small as these mostly wait for each other.
    with limited(1), one_blas_thread():
        return search.run(joints_of(question, model), seed, part(progress, 0.15, 1.0))


def joints_of(question: Question, model: Model) -> Sequence[str]:
    """Return the joints that a question is about.

    Raises:
        ModelError: the model lacks one.
    """
    if isinstance(question, Everything):
        return model.joints
    if isinstance(question, For):
        suspects = [question.suspect]
    else:
        suspects = [question.first, question.second]
    for one in suspects:
        if one.joint not in model.joints:
            raise ModelError(f"there is no joint {one.joint}; there are {', '.join(model.joints)}")
    return list(dict.fromkeys(one.joint for one in suspects))


def pose_for(question: Question, model: Model, limits: Limits) -> Floats:
    """Return (N,) rad, where a motion for a question begins; see `seen_pose`."""
    wanted = joints_of(question, model)
    return seen_pose(model, wanted[0] if len(wanted) == 1 else None, limits)


@dataclass(frozen=True)
class _Found:
    """Control points (K, N) of a clear motion, and the log of the nats in it, less the excess."""

    control: Floats
    value: float
    begun: str


@dataclass(frozen=True)
class _Search:
    """A search for the control points of the best motion."""

    question: Question
    objective: Objective
    keeper: Keeper
    pose: Floats
    effort: Effort

    @classmethod
    def of(
        cls,
        assumed: Assumed,
        question: Question,
        keeper: Keeper,
        pose: Floats,
        seconds: float,
        size: float,
        effort: Effort,
        seed: int,
    ) -> "_Search":
        splines = Splines(GRID * round(seconds / GRID), round(seconds / SPACING) + DEGREE)
        every = Objective(
            assumed,
            cases_of(question, assumed, size),
            splines,
            size,
            _some(len(splines.time), effort.rows // len(pose), seed),
            dynamics=isinstance(question, Everything),
        )
        return cls(question, every, keeper, pose, effort)

    def run(self, wanted: Sequence[str], seed: int, progress: Progress) -> Design:
        """Return the best motion."""
        found, done, finished = self._starts(wanted, seed, progress), 0, True
        first, rounds = self.effort.first, self.effort.rounds
        steps = self.effort.starts * first + sum(count for count, _ in rounds)

        def told(name: str, count: int) -> None:
            nonlocal done
            done += count
            progress(0.15 + 0.75 * done / steps, f"climbing from {name}")

        try:
            climbed = []
            for one in found[: self.effort.starts]:
                climbed.append(self._climbed(one, first, rounds[0][1]))
                found = sorted([*climbed, *found], key=lambda one: -one.value)
                told(one.begun, first)
            for number, (count, hard) in enumerate(rounds, start=1):
                # Other samples each time: a motion must not suit some of them alone.
                found = [self._at(seed + number)._climbed(found[0], count, hard), *found]
                told(found[0].begun, count)
        except KeyboardInterrupt:
            finished = False
        progress(0.9, "predicting what it will show")
        return replace(self._design(found), finished=finished)

    def _at(self, seed: int) -> "_Search":
        """Return the search on other samples."""
        index = _some(len(self.objective.splines.time), self.effort.rows // len(self.pose), seed)
        return replace(self, objective=replace(self.objective, index=index))

    def _starts(self, wanted: Sequence[str], seed: int, progress: Progress) -> list[_Found]:
        """Return motions to climb from, best first."""
        limits, splines = self.keeper.limits, self.objective.splines
        joints = self.keeper.model.joints
        found = []
        for number, (name, q) in enumerate(
            starts_of(joints, wanted, limits, self.pose, splines.seconds, seed)
        ):
            progress(0.15 * min(1.0, number / 40), "looking at the templates")
            near = np.clip(splines.nearest(q, self.pose), limits.q_low, limits.q_high)
            control = self.keeper.cleared(splines, near, np.tile(self.pose, (splines.count, 1)))
            if control is not None:
                value = self._value(control, self.effort.rounds[0][1])
                found.append(_Found(control, value, name))
        if not found:
            raise ModelError("no motion from the start is clear: name another, or fewer obstacles")
        return sorted(found, key=lambda one: -one.value)

    def _value(self, control: Floats, hard: float) -> float:
        look = self.objective.look(control, slope=False)
        return look.value - hard * self.keeper.penalty(self.objective.splines, control)[0]

    def _climbed(self, begin: _Found, steps: int, hard: float) -> _Found:
        """Return the motion after some looks on the way uphill."""
        limits, splines = self.keeper.limits, self.objective.splines
        free = slice(AT_REST, splines.count - AT_REST)
        control = begin.control.copy()

        def down(z: Floats) -> tuple[float, Floats]:
            control[free] = z.reshape(-1, control.shape[1])
            look = self.objective.look(control)
            slope = self.objective.slope(look, control)
            excess, by_control = self.keeper.penalty(splines, control)
            return hard * excess - look.value, (hard * by_control - slope)[free].ravel()

        ends = zip(limits.q_low, limits.q_high, strict=True)
        found = scipy.optimize.minimize(
            down,
            begin.control[free].ravel(),
            jac=True,
            method="L-BFGS-B",
            bounds=list(ends) * (splines.count - 2 * AT_REST),
            options={"maxiter": steps, "maxfun": steps},
        )
        control[free] = found.x.reshape(-1, control.shape[1])
        clear = self.keeper.cleared(splines, control, begin.control)
        if clear is None:
            return begin
        return _Found(clear, self._value(clear, hard), begin.begun)

    def _design(self, found: Sequence[_Found]) -> Design:
        """Return the best of the motions, slowed down where it does not keep the limits."""
        for one in found:
            control = self._held(one.control)
            while (splines := self.keeper.kept(self.objective.splines, control)) is None:
                control = self.pose + SMALLER * (control - self.pose)
                if np.ptp(control, axis=0).max() < 0.1 * LEAST:
                    break
            else:
                return self._predicted(splines, control, one.begun)
        raise ModelError(
            "no motion keeps the limits: at the start, the torque predicted comes too near to its "
            "limit already; name another start or other limits"
        )

    def _held(self, control: Floats) -> Floats:
        """Return control points with joints held that hardly move, if the way is clear then.

        Static friction of a joint that creeps by some mrad has no form that a model knows.
        """
        held = control.copy()
        hardly = np.ptp(control, axis=0) < LEAST
        held[:, hardly] = self.pose[hardly]
        clear = self.keeper.cleared(self.objective.splines, held, held)
        return control if clear is None else held

    def _predicted(self, splines: Splines, control: Floats, begun: str) -> Design:
        size, reference = self.objective.size, splines.reference(control)
        assumed = self.objective.assumed.suited_to(reference)
        groups = self.objective.groups
        asked = [case.true for group in groups for case in group]
        keys = {one.key for one in asked}
        others = [one for one in representative(assumed.base) if one.key not in keys]
        expected = assumed.gains(reference, size, [*asked, *others])
        nats = nats_of(assumed, groups, reference, size)
        if isinstance(self.question, For):
            name, joint = self.question.suspect.effect, self.question.suspect.joint
            own = [one.nats for one in expected if (one.effect, one.joint) == (name, joint)]
            nats = min(nats, *own)
        used = self.keeper.used(reference)
        joints = assumed.model.joints
        excess = assumed.model.range.excess(States.of(*reference[1:])).max(axis=0)
        beyond = tuple(name for name, share in zip(joints, excess, strict=True) if share > 1e-6)
        return Design(self.question, joints, reference, nats, expected, used, begun, beyond)


def _some(available: int, wanted: int, seed: int) -> Ints:
    """Return (S,) samples to look at, one somewhere in each of as many even stretches."""
    count = int(np.clip(wanted, FEWEST, MOST))
    place = np.arange(count) + np.random.default_rng(seed).uniform(size=count)
    return np.asarray(place * available / count, dtype=np.int64)
