"""The torques of a whole reference, computed when it arrives so that streaming only looks up."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.effects import PARTS
from lagrangian_ff.errors import UserError
from lagrangian_ff.identification.predicting import MotionRange, Terms, by_part
from lagrangian_ff.nodes.streaming.ranges import (
    Doubts,
    Excess,
    along,
    doubt_words,
    excess,
    fade_around,
)
from lagrangian_ff.nodes.streaming.reference import Reference, RefusedReference

TERMS = PARTS
FIRST = np.zeros(1, dtype=np.int64)
STEP = 0.004  # s between samples at most: friction changes in milliseconds where a joint reverses
CHUNK = 16  # samples per call of the model; between calls other threads get their turn

Tag = TypeVar("Tag")


class InverseDynamics(Protocol):
    """The part of an identified model that plans need."""

    @property
    def joints(self) -> tuple[str, ...]: ...
    @property
    def range(self) -> MotionRange: ...
    def terms(self, q: Floats, qd: Floats, qdd: Floats) -> Terms: ...


@dataclass(frozen=True)
class Policy:
    """The treatment of references outside the identified range.

    Attributes:
        out_of_range: "refuse" the reference, "fade" its torque to zero there, or "allow" it.
        margin: how far beyond the range still counts as inside, as a fraction of its width.
        fade_time: s over which the torque fades.
        doubt_limit: the doubt of a torque above which a state counts as outside; 0 = never.
    """

    out_of_range: str = "fade"
    margin: float = 0.25
    fade_time: float = 0.5
    doubt_limit: float = 0.0


@dataclass(frozen=True)
class Plan:
    """The torques along a reference, term by term.

    Attributes:
        reference: the motion.
        time: (L,) s from the start.
        parts: (L, 4, N) N·m: gravity, inertia, coriolis, friction.
        weight: (L,) 0 outside the identified range, 1 inside, fading between.
        before, after: (4, N) N·m at rest at the first and at the last point.
        own: (K,) indices of the reference's own points among the L samples.
        excess: the samples outside the identified range.
        known: the identified range of the model, by which the stream knows models apart.
        doubt: (N,) the largest of each joint's torque; None if it was not evaluated.
    """

    reference: Reference
    time: Floats
    parts: Floats
    weight: Floats
    before: Floats
    after: Floats
    own: Ints
    excess: Excess
    known: MotionRange
    doubt: Floats | None = None

    def at(self, elapsed: float) -> tuple[Floats, float]:
        """Return the parts (4, N) N·m and the weight, `elapsed` s after the start."""
        time = self.time
        if len(time) == 1:
            return self.parts[0], float(self.weight[0])
        if elapsed < time[0]:
            return self.before, float(self.weight[0])
        if elapsed > time[-1]:
            return self.after, float(self.weight[-1])
        right = min(int(np.searchsorted(time, elapsed, side="right")), len(time) - 1)
        share = (elapsed - time[right - 1]) / (time[right] - time[right - 1])
        parts = self.parts[right - 1] * (1.0 - share) + self.parts[right] * share
        weight = self.weight[right - 1] * (1.0 - share) + self.weight[right] * share
        return parts, float(weight)

    def effort(self, switches: Floats, scale: Floats, limit: Floats) -> Floats:
        """Return the torque (L, N) N·m.

        Args:
            switches: (4,) 1 or 0 for each term.
            scale, limit: (N,) factor and largest torque, N·m, of each joint.
        """
        tau = np.einsum("t,ltn->ln", switches, self.parts) * scale * self.weight[:, None]
        return np.clip(tau, -limit, limit)


def make_plan(
    model: InverseDynamics,
    reference: Reference,
    policy: Policy,
    report: Callable[[float], None] = lambda fraction: None,
    doubts: Doubts | None = None,
) -> Plan:
    """Return the torques of a reference.

    Args:
        model: of the joints of the reference, in the same order.
        report: receives the share done after each chunk, 0 to 1; may raise to cancel.
        doubts: evaluates how far torques are a guess; None if the model cannot.

    Raises:
        RefusedReference: it leaves the identified range and the policy is to refuse, or the
            model gives no finite torque.
    """
    if reference.is_setpoint:
        return _setpoint_plan(model, reference, policy, doubts)
    time, own = _refine(reference.time)
    states = reference.sample(time)
    found = excess(reference.joints, time, states, model.range, policy.margin)
    doubt = None
    if doubts is not None:
        doubt = along(doubts, time, states, lambda: report(0.0))
        found = _with_doubt(found, model, time, doubt, policy.doubt_limit)
    _require_inside(found, policy)
    if policy.out_of_range == "fade":
        weight = fade_around(time, found.outside, policy.fade_time)
    else:
        weight = np.ones(len(time))
    parts = np.empty((len(time), len(TERMS), len(reference.joints)))
    for first in range(0, len(time), CHUNK):
        rows = slice(first, first + CHUNK)
        parts[rows] = _parts(model, *(array[rows] for array in states))
        report(min(1.0, (first + CHUNK) / len(time)))
    ends = reference.q[[0, -1]]
    still = np.zeros_like(ends)
    before, after = _parts(model, ends, still, still)
    _require_finite(parts, before, after)
    most = None if doubt is None else doubt.max(axis=0)
    return Plan(reference, time, parts, weight, before, after, own, found, model.range, most)


def _setpoint_plan(
    model: InverseDynamics, reference: Reference, policy: Policy, doubts: Doubts | None
) -> Plan:
    """Return the plan of a single state, without what a trajectory needs: it may come at 1 kHz."""
    time, states = reference.time, (reference.q, reference.qd, reference.qdd)
    found = excess(reference.joints, time, states, model.range, policy.margin)
    doubt = None if doubts is None else doubts(*states)
    if doubt is not None:
        found = _with_doubt(found, model, time, doubt, policy.doubt_limit)
    _require_inside(found, policy)
    parts = _parts(model, *states)
    _require_finite(parts)
    weight = np.ones(1)
    if policy.out_of_range == "fade":
        weight[found.outside] = 0.0
    most = None if doubt is None else doubt[0]
    ends = parts[0], parts[0]
    return Plan(reference, time, parts, weight, *ends, FIRST, found, model.range, most)


def _require_inside(found: Excess, policy: Policy) -> None:
    if found.worst and policy.out_of_range == "refuse":
        raise RefusedReference(
            f"outside the identified range: {found.worst}; identify on a larger motion, slow "
            "the reference down, or set out_of_range to fade or allow"
        )


def _require_finite(*parts: Floats) -> None:
    if not all(np.isfinite(part).all() for part in parts):
        raise RefusedReference("the model gives no finite torque for this reference")


def _with_doubt(
    found: Excess, model: InverseDynamics, time: Floats, doubt: Floats, limit: float
) -> Excess:
    """Return the excess with the states added whose torque (L, N) is too much of a guess."""
    if limit == 0.0:
        return found
    worst = found.worst or doubt_words(model.joints, time, doubt, model.range.tau_max, limit)
    return Excess(found.outside | (doubt > limit).any(axis=1), worst)


def _refine(time: Floats) -> tuple[Floats, Ints]:
    """Return times at most `STEP` apart, and the indices of the given ones among them."""
    # Rounding must not double the samples of a reference that already has this step.
    pieces = np.maximum(1, np.ceil(np.diff(time) / STEP - 1e-6).astype(np.int64))
    own = np.concatenate([[0], np.cumsum(pieces)])
    return np.interp(np.arange(own[-1] + 1), own, time), own


def _parts(model: InverseDynamics, q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """Return (L, 4, N) the parts of the torque at L states, see `by_part`."""
    parts = by_part(model.terms(q, qd, qdd))
    return np.stack([parts[term] for term in TERMS], axis=1)


class _SupersededError(Exception):
    """The task was replaced by a newer one."""


class Planner(Generic[Tag]):
    """A thread that turns references into plans; a newer one replaces an older one.

    Args:
        done: called in this thread with each plan and the tag of its reference.
        failed: called in this thread with the reason why there is no plan.
        doubts: evaluates how far torques are a guess; None if the model cannot.

    Attributes:
        fraction: share done of the present plan, 0 to 1; 1 without one.
    """

    def __init__(
        self,
        model: InverseDynamics,
        done: Callable[[Plan, Tag], None],
        failed: Callable[[Exception], None],
        doubts: Doubts | None = None,
    ) -> None:
        self.use(model, doubts)
        self._done = done
        self._failed = failed
        self._wake = threading.Condition()
        self._task: tuple[Callable[[], tuple[Reference, Tag]], Policy] | None = None
        self._ended = False
        self.fraction = 1.0
        self._thread = threading.Thread(target=self._run, name="planner", daemon=True)
        self._thread.start()

    def use(self, model: InverseDynamics, doubts: Doubts | None) -> None:
        """Compute the plans of what is submitted from now on with this model."""
        self._with = model, doubts

    @property
    def idle(self) -> bool:
        """Return whether no plan is being computed."""
        return self._task is None

    def submit(self, read: Callable[[], tuple[Reference, Tag]], policy: Policy) -> None:
        """Compute the plan of this reference next, and nothing older.

        Args:
            read: called in the thread; returns the reference and its tag.
        """
        with self._wake:
            self._task = read, policy
            self._wake.notify()

    def drop(self) -> None:
        """Forget what was submitted."""
        with self._wake:
            self._task = None
            self.fraction = 1.0

    def stop(self) -> None:
        """End the thread."""
        with self._wake:
            self._ended, self._task = True, None
            self._wake.notify()
        self._thread.join(timeout=2.0)

    def _run(self) -> None:
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._task is not None or self._ended)
                task = self._task
            if task is None:
                return
            try:
                self._work(*task, task)
            except _SupersededError:
                continue
            except Exception as error:
                self._end(task)
                self._failed(error)

    def _work(
        self, read: Callable[[], tuple[Reference, Tag]], policy: Policy, task: object
    ) -> None:
        def report(fraction: float) -> None:
            if self._task is not task:
                raise _SupersededError
            self.fraction = fraction

        self.fraction = 0.0
        reference, tag = read()
        model, doubts = self._with
        plan = make_plan(model, reference, policy, report, doubts)
        if self._end(task):
            self._done(plan, tag)

    def _end(self, task: object) -> bool:
        """Forget this task and return whether it was still the newest."""
        with self._wake:
            newest = self._task is task
            if newest:
                self._task = None
            self.fraction = 1.0
            return newest


def reason(error: Exception) -> str:
    """Return the text to show: a user's mistake as it is, anything else with its type."""
    return str(error) if isinstance(error, UserError) else f"{type(error).__name__}: {error}"
