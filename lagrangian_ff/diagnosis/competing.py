"""Single causes of a change since a model was identified, which compete by evidence.

Another gain of a joint's drive, other masses, and other friction of a joint each change much at
once. The strongest is explained, and the others are compared again.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.arrays import Flags
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.bodies import TILT, BodyChange, changed_bodies, unknown_gains
from lagrangian_ff.diagnosis.causes import Friction, Gain, gain, gain_half, gains
from lagrangian_ff.diagnosis.intervals import GAIN
from lagrangian_ff.diagnosis.results import Change
from lagrangian_ff.diagnosis.run import Changed
from lagrangian_ff.diagnosis.search.change import FINE, beyond_chance, joints_of
from lagrangian_ff.diagnosis.whitening import Changing, Whitened, fit_for, refit, whiten
from lagrangian_ff.diagnosis.whitening.whitened import rigid_torque
from lagrangian_ff.effects.base import Floats
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.problem import Nuisance, Problem
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.identification.solving.posterior import exact
from lagrangian_ff.progress import Progress, part
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.words import which

MASSES = "rigid body"
"""The name of a change of masses, as by a load."""
DRIVE = "torque_gain"
"""The name of another gain of a drive."""


@dataclass(frozen=True)
class Cause:
    """A change with its torque.

    Attributes:
        changed: the result.  torque: (S, N) N·m that it adds at the samples used.
    """

    changed: Changed
    torque: Floats


def without_causes(
    model: Model, both: Motion, boundary: float, found: list[Cause], progress: Progress
) -> Whitened:
    """Return the motion with gains and masses that changed explained, and append them to `found`.

    Where other friction of a joint is the better explanation, the search of effects names it.
    """
    whitened = fit_for(model, both, progress=part(progress, 0.0, 0.6))
    later: Flags = whitened.x.time >= boundary
    settled: set[int] = set()  # joints whose gain or friction is explained
    worn: list[Nuisance] = []
    bodies = False
    while True:
        progress(0.7 + 0.05 * len(found), "comparing causes: gains, masses, friction")
        open_joints = [n for n in range(whitened.joints) if n not in settled]
        options: list[Gain | Friction | _Bodies] = [
            *(one for one in gains(whitened, later, open_joints) if _stands_out(one)),
            *(one for one in _frictions(whitened, later, open_joints) if _stands_out(one)),
        ]
        heavier = None if bodies else _bodies(whitened, model, boundary)
        options += [heavier] if heavier else []
        if not options:
            break
        best = _chosen(options, whitened, later)
        if isinstance(best, _Bodies):
            whitened, cause = best.explained(whitened)
            bodies = True
            found.append(cause)
        elif isinstance(best, Friction):
            settled.add(best.joint)
            worn.append(Nuisance(best.joint, best.columns))
            whitened = whitened.explaining(whitened.basis, (*whitened.problem.nuisance, worn[-1]))
        else:
            settled.update(best.joints)
            problem = whitened.problem
            del whitened
            whitened, cause = _undone(model, both, boundary, best, problem)
            found.append(cause)
            both = whitened.motion
    every = whitened.problem.nuisance
    lasting = tuple(one for one in every if not any(one is other for other in worn))
    return whitened.explaining(whitened.basis, lasting) if worn else whitened


def _frictions(whitened: Whitened, later: Flags, joints: Sequence[int]) -> list[Friction]:
    return [Friction.of(whitened, later, joint) for joint in joints]


def _stands_out(cause: Gain | Friction) -> bool:
    """Return whether a cause is strong, and large enough, to be claimed."""
    if isinstance(cause, Gain) and abs(np.expm1(cause.logarithm)) < thresholds.USED.least_size:
        return False
    return cause.log_bf > thresholds.USED.floor


def _chosen(
    options: "Sequence[Gain | Friction | _Bodies]", whitened: Whitened, later: Flags
) -> "Gain | Friction | _Bodies":
    """Return the cause of the largest evidence; those near the best with the noise that suits."""
    least = thresholds.USED.near * max(one.evidence for one in options)
    near = [one for one in options if one.evidence >= least]
    if len(near) == 1:
        return near[0]

    def suited(one: "Gain | Friction | _Bodies") -> float:
        return one.suited(whitened, later) if isinstance(one, Gain) else one.suited(whitened)

    return max(near, key=suited)


@dataclass(frozen=True)
class _Bodies:
    """Other bodies: masses in general, and of a known robot which of them.

    Attributes:
        evidence: nats, to compare causes.
        second: the second Lagrangian as `Problem.change`, and its nats; None if not strongly
            needed.
        named: what of a known robot changed; None if not strongly needed, or not known.
        model: the model that may know the robot.
    """

    evidence: float
    second: tuple[tuple[float, float, float], float] | None
    named: BodyChange | None
    model: Model

    def suited(self, whitened: Whitened) -> float:
        """Return the log evidence with the noise that suits it, see `Gain.suited`."""
        nuisance = whitened.problem.nuisance
        change = self.second[0] if self.second else None
        if self.named is not None:
            torque = self.named.torque
            nuisance += tuple(Nuisance(n, torque[:, [n]]) for n in range(whitened.joints))
        return exact(refit(whitened, whitened.basis, nuisance, change)).system.log_evidence

    def explained(self, whitened: Whitened) -> tuple[Whitened, Cause]:
        """Return the motion with the change explained, and the change."""
        every = self.model.joints
        if self.second is not None:
            change, nuisance = self.second[0], whitened.problem.nuisance
            whitened = whitened.assuming(refit(whitened, whitened.basis, nuisance, change))
        if self.named is None:
            assert self.second is not None
            felt, share = joints_of(whitened)
            size = float(np.max(share) * whitened.spread[int(np.argmax(share))])
            names = tuple(every[n] for n in felt)
            made = Changed(MASSES, names, self.second[1], None, {}, size)
            return whitened, Cause(made, _of_second(whitened))
        extra = [Nuisance(n, self.named.torque[:, [n]]) for n in range(whitened.joints)]
        nuisance = (*whitened.problem.nuisance, *extra)
        made = _named(self.named, whitened, self.model)
        return whitened.explaining(whitened.basis, nuisance), Cause(made, self.named.torque)


def _bodies(whitened: Whitened, model: Model, boundary: float) -> _Bodies | None:
    """Return other bodies from the boundary on, if strongly needed."""
    floor = thresholds.USED.change_floor
    named = changed_bodies(model, whitened, boundary)
    if named is not None and named.log_bayes_factor <= floor:
        named = None
    changing = Changing.of(whitened, len(whitened.index))
    log_bf, share = max((changing.log_bayes_factor((boundary, np.inf, one)), one) for one in FINE)
    second = ((boundary, np.inf, share), log_bf) if log_bf >= floor else None
    # More than with the blocks of both recordings mixed.
    change = Change(boundary, np.inf, share, log_bf)
    if beyond_chance(whitened, change) < thresholds.USED.change_beyond_chance:
        return None
    if named is None and second is None:
        return None
    evidence = max(named.evidence if named else -np.inf, log_bf if second else -np.inf)
    return _Bodies(evidence, second, named, model)


def _named(change: BodyChange, whitened: Whitened, model: Model) -> Changed:
    """Return a change of a known robot's bodies as a result."""
    rms = np.sqrt(np.mean(change.torque**2, axis=0))
    order = [int(n) for n in np.argsort(-rms / whitened.spread)]
    felt = [n for n in order if rms[n] > thresholds.USED.felt * whitened.spread[n]] or order[:1]
    joints, size = tuple(model.joints[n] for n in felt), float(rms[felt[0]])
    nats = change.log_bayes_factor
    made = Changed(change.what, joints, nats, None, change.parameters, size, change.rivals)
    unsure = [name for name, by in zip(model.joints, unknown_gains(model), strict=True) if by > 0.0]
    if change.what == TILT or not unsure:
        return made
    words = (
        f"its intervals allow for gains of the drives that are {GAIN:.0%} wrong on "
        f"{which(unsure, model.joints)}; with N·m per unit of effort as measured, given by "
        "--effort-scale when the model is identified, they are narrower"
    )
    return replace(made, note=words)


def _of_second(whitened: Whitened) -> Floats:
    """Return (S, N) N·m that the second Lagrangian adds."""
    problem, x = whitened.problem, whitened.x
    weights = whitened.system.weights.reshape(len(x), whitened.joints)
    without = rigid_torque(replace(problem, change=None), x, weights)
    return np.asarray(rigid_torque(problem, x, weights) - without)


def _undone(
    model: Model, both: Motion, boundary: float, drive: Gain, problem: Problem
) -> tuple[Whitened, Cause]:
    """Return the motion with the torques that another gain scaled scaled back, and the change.

    Args:
        problem: what is explained besides.
    """
    at = np.ix_(np.flatnonzero(both.time >= boundary), np.array(drive.joints))

    def scaled(logarithm: float) -> Motion:
        tau = both.tau.copy()
        tau[at] *= np.exp(-logarithm)
        return replace(both, tau=tau)

    whitened = fit_for(model, scaled(drive.logarithm))
    # With the noise that is left now, the gain is known much better.
    again = gain(whitened, whitened.x.time >= boundary, drive.joints)
    total = drive.logarithm + again.logarithm
    parts = whitened.index, whitened.seconds, whitened.inputs
    own = whitened.problem
    whitened = whiten(scaled(total), *parts, own, whitened.x, whitened.system)
    if problem.change is not None:
        refitted = refit(whitened, whitened.basis, problem.nuisance, problem.change)
        whitened = whitened.assuming(refitted)
    if problem.nuisance:
        whitened = whitened.explaining(whitened.basis, problem.nuisance)
    half = gain_half(whitened, whitened.x.time >= boundary, drive.joints)
    torque = np.zeros_like(own.samples.tau)
    columns, x = list(drive.joints), whitened.x
    since = x.time >= boundary
    torque[:, columns] = x.mean(both.tau)[:, columns] * -np.expm1(-total) * since[:, None]
    size = float(np.sqrt(np.mean(torque[since][:, columns[0]] ** 2)))
    best, low, high = np.expm1([total, total - half, total + half]).tolist()
    names = tuple(model.joints[n] for n in drive.joints)
    made = Changed(DRIVE, names, drive.log_bf, None, {"g": Estimate(best, low, high, "1")}, size)
    return whitened, Cause(made, torque)
