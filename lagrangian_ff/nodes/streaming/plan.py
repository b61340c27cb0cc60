"""The torques of a whole reference, computed when it comes in so that streaming only looks up."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.nodes.common.errors import RefusedReference
from lagrangian_ff.nodes.streaming.doubt import Doubts, along, words
from lagrangian_ff.nodes.streaming.ranges import Excess, Range, excess, fade_around
from lagrangian_ff.nodes.streaming.reference import Reference

Floats = NDArray[np.float64]

TERMS = ("gravity", "inertia", "coriolis", "friction")
FIRST = np.zeros(1, dtype=np.int64)


class TermTorques(Protocol):
    """The parts of a torque, each (L, N) in N·m."""

    @property
    def gravity(self) -> Floats: ...
    @property
    def inertia(self) -> Floats: ...
    @property
    def coriolis(self) -> Floats: ...
    @property
    def effects(self) -> Mapping[str, Floats]: ...


class InverseDynamics(Protocol):
    """What is needed of an identified model."""

    @property
    def joints(self) -> tuple[str, ...]: ...
    @property
    def range(self) -> Range: ...
    def terms(self, q: Floats, qd: Floats, qdd: Floats) -> TermTorques: ...


@dataclass(frozen=True)
class Policy:
    """How references outside the identified range are met.

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
        reference: what is followed.
        time: (L,) s from the start.
        parts: (L, 4, N) N·m: gravity, inertia, coriolis, friction.
        weight: (L,) 0 outside the identified range, 1 inside, fading between.
        before, after: (4, N) N·m at rest at the first and at the last point.
        own: (K,) which of the L samples are the reference's own points.
        excess: what lies outside the identified range.
        doubt: (N,) the largest of each joint's torque; None where it was not asked for.
    """

    reference: Reference
    time: Floats
    parts: Floats
    weight: Floats
    before: Floats
    after: Floats
    own: NDArray[np.int64]
    excess: Excess
    doubt: Floats | None = None

    def at(self, elapsed: float) -> tuple[Floats, float]:
        """(4, N) parts and the weight, `elapsed` seconds after the start."""
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
        """(K, N) N·m at the reference's own points.

        Args:
            switches: (4,) 1 or 0 for each term.
            scale: (N,) factor of each joint.
            limit: (N,) largest torque of each joint, N·m.
        """
        parts = self.parts[self.own]
        tau = np.einsum("t,ltn->ln", switches, parts) * scale * self.weight[self.own][:, None]
        return np.clip(tau, -limit, limit)


def make_plan(
    model: InverseDynamics,
    reference: Reference,
    policy: Policy,
    step: float = 0.004,
    report: Callable[[float], None] = lambda fraction: None,
    chunk: int = 16,
    doubts: Doubts | None = None,
) -> Plan:
    """Compute the torques of a reference.

    Args:
        model: gives the torques.
        reference: its joints are those of the model, in the same order.
        policy: what to do outside the identified range.
        step: s, the widest distance between samples: friction changes within milliseconds
            when a joint reverses, so sparse points are not enough.
        report: told the fraction done after each chunk; may raise to cancel.
        chunk: samples per call of the model; between calls other threads get their turn.
        doubts: how far torques are a guess, where the model tells.

    Raises:
        RefusedReference: it leaves the identified range and the policy is to refuse, or the
            model gives no finite torque.
    """
    if reference.is_setpoint:
        return _setpoint_plan(model, reference, policy, doubts)
    time, own = _refine(reference.time, step)
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
    for first in range(0, len(time), chunk):
        rows = slice(first, first + chunk)
        parts[rows] = _parts(model, *(array[rows] for array in states))
        report(min(1.0, (first + chunk) / len(time)))
    ends = reference.q[[0, -1]]
    still = np.zeros_like(ends)
    before, after = _parts(model, ends, still, still)
    _require_finite(parts, before, after)
    most = None if doubt is None else doubt.max(axis=0)
    return Plan(reference, time, parts, weight, before, after, own, found, most)


def _setpoint_plan(
    model: InverseDynamics, reference: Reference, policy: Policy, doubts: Doubts | None
) -> Plan:
    """The plan of a single state, with nothing that a trajectory needs: it may come at 1 kHz."""
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
    return Plan(reference, time, parts, weight, parts[0], parts[0], FIRST, found, most)


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
    """What is outside with the states whose torque (L, N) is too much of a guess."""
    if limit == 0.0:
        return found
    told = words(model.joints, time, doubt, model.range.tau_max, limit)
    return Excess(found.outside | (doubt > limit).any(axis=1), found.worst or told)


def _refine(time: Floats, step: float) -> tuple[Floats, NDArray[np.int64]]:
    """Times at most `step` apart that include the given ones, and where those are."""
    # Rounding must not double the samples of a reference that already has this step.
    pieces = np.maximum(1, np.ceil(np.diff(time) / step - 1e-6).astype(np.int64))
    own = np.concatenate([[0], np.cumsum(pieces)])
    return np.interp(np.arange(own[-1] + 1), own, time), own


def _parts(model: InverseDynamics, q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """(L, 4, N) the parts of the torque at L states.

    A constant offset counts as gravity: without an independent measurement of one of them, an
    identification may share the mean of gravity between the two in any way.
    """
    terms = model.terms(q, qd, qdd)
    parts = np.zeros((len(q), len(TERMS), q.shape[1]))
    parts[:, 0], parts[:, 1], parts[:, 2] = terms.gravity, terms.inertia, terms.coriolis
    for name, torque in terms.effects.items():
        parts[:, 0 if name == "offset" else 3] += torque
    return parts
