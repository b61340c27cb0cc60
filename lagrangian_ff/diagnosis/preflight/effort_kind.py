"""What the recorded effort holds, from the torques alone: gravity, and friction.

A serial arm of unknown masses with plain friction (`chain+fri`) is fitted to some samples. Gravity
is judged by two Bayes factors against none: of gravity that is free in size, which shows that it is
there; and of gravity that is half of the torque, which shows that it is not, since a size that is
free may be nothing. Friction is judged by the power that it takes, which is linear in its
parameters: where it gives some, the effort has the other sign.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from lagrangian_ff.diagnosis.preflight.base import ENOUGH, SIGN, Check, Remedy, turned_round
from lagrangian_ff.diagnosis.thresholds import USED
from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.choosing.evidence import Logarithms, maximise_evidence, solvable
from lagrangian_ff.identification.problem import Problem, Scaling
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.identification.samples import Samples, decimated, evenly, groups
from lagrangian_ff.identification.solving.posterior import Posterior, exact
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.identification.spec import parse
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.structured.base import Structured
from lagrangian_ff.recording.motion import TOTAL, WITHOUT_FRICTION, WITHOUT_GRAVITY, Motion
from lagrangian_ff.sampling import recorded_seconds, usual_step

MODEL = "chain+fri"
STAGES = ((60, 15), (100, 4))
"""Samples that the evidence is maximised on, and steps at most."""
HALF = 0.5
"""Share of the torque, whose absence is judged: gravity of an arm is seldom less."""
AVERAGED = 0.07
"""s over which samples are averaged at most."""
ABSENT = 5.0
"""Nats by which gravity of half the torque must lose to be absent: odds of 150 to 1."""
WHOLE = 0.15
"""Share of the torque's spread above which gravity is no remainder of a compensation."""
LITTLE = 0.03
"""Share of a joint's power that friction takes at least where a gear's is in the torque."""
ALL_POWER = 1.05
"""Share of a joint's power that no friction exceeds: what does was split off wrongly."""
NAME = "effort kind"
BLOCKS = 10
"""Parts of the time that intervals are resampled over."""
LEVEL = 0.95
"""The upper end of a 90 % interval."""
ALL = Remedy("Read the effort as all torque", effort=TOTAL)
WEIGHTLESS = Remedy("Read the effort as without gravity", effort=WITHOUT_GRAVITY)
FRICTIONLESS = Remedy("Read the effort as without friction", effort=WITHOUT_FRICTION)


@dataclass(frozen=True)
class EffortKind:
    """What the torques of a recording show of what its effort holds.

    Attributes:
        joints: N names.
        gravity: nats, log Bayes factor of gravity of any size against none.
        large_gravity: nats, the same of gravity that is `HALF` of the torque: far below 0 where
            none is there, and the motion would show it.
        gravity_share: spread of the torque of gravity over that of the torque, of all joints.
        friction: by joint, the share of the joint's power that plain friction takes.
        turned: joints that friction drives, where the other torques allow their sign to be wrong.
    """

    joints: tuple[str, ...]
    gravity: float
    large_gravity: float
    gravity_share: float
    friction: tuple[Estimate, ...]
    turned: tuple[str, ...] = ()


def kind_checks(motion: Motion, sliding: Sequence[int] = ()) -> list[Check]:
    """Return what the torques contradict, or suggest, of the `effort` that a motion was read with.

    Args:
        motion, sliding: see `effort_kind`.
    """
    found = effort_kind(motion, sliding)
    if found is None:
        return []
    return [*_of_sign(found, motion), *_of_gravity(found, motion), *_of_friction(found, motion)]


def _of_sign(found: EffortKind, motion: Motion) -> list[Check]:
    """Return the joints whose effort has the other sign."""
    each, turned = dict(zip(found.joints, found.friction, strict=True)), found.turned
    if not turned or motion.effort == WITHOUT_FRICTION:
        return []  # a drive may give more than it loses
    turned_of: dict[str | None, Sequence[str]]
    if len(turned) == len(each) > 1:
        turned_of = {None: turned}
    else:
        turned_of = {name: [name] for name in turned}
    checks = []
    for joint, names in turned_of.items():
        remedy = turned_round(motion, names)
        shown = ", ".join(f"{name}: {-each[name].value:.0%} of its power" for name in names)
        finding = (
            f"the effort of {joint or 'every joint'} seems to have the wrong sign: as recorded, "
            f"friction drives and does not brake ({shown})"
        )
        values = {name: each[name].value for name in names}
        advice = f"Give {remedy.option}, or correct the driver"
        checks.append(Check(SIGN, joint, finding, True, advice, values, remedy=remedy))
    return checks


def _of_gravity(found: EffortKind, motion: Motion) -> list[Check]:
    values = {
        "gravity, log BF": found.gravity,
        "half gravity, log BF": found.large_gravity,
        "gravity, share": found.gravity_share,
    }
    if motion.effort == WITHOUT_GRAVITY:
        if found.gravity < USED.floor:
            return []
        gains = (
            f"it makes {found.gravity_share:.0%} of the torque's spread, and with it the torques "
            f"gain {found.gravity:.0f} nats"
        )
        if found.gravity_share > WHOLE:
            finding = f"the effort was read as without gravity, but holds it: {gains}"
            advice = f"Read it with {ALL.option}"
            return [Check(NAME, None, finding, True, advice, values, remedy=ALL)]
        finding = f"some gravity is left in the effort: {gains}"
        advice = (
            "The driver's masses, or the payload it knows of, may be a little wrong. "
            f"{ALL.option} learns what is left over, and feeds it forward"
        )
        return [Check(NAME, None, finding, False, advice, values, remedy=ALL)]
    if found.gravity > ABSENT or found.large_gravity > -ABSENT:
        return []
    finding = (
        "no torque of gravity shows: gravity of half the torque loses "
        f"{-found.large_gravity:.0f} nats, of any size it gains {max(found.gravity, 0.0):.0f}. The "
        "driver removed it, or no joint works against it"
    )
    advice = (
        f"If the driver compensates gravity, give {WEIGHTLESS.option}: model and feedforward "
        "then have exactly none. If all axes stand upright, either is right"
    )
    return [Check(NAME, None, finding, False, advice, values, remedy=WEIGHTLESS)]


def _of_friction(found: EffortKind, motion: Motion) -> list[Check]:
    each = dict(zip(found.joints, found.friction, strict=True))
    values: dict[str, float] = {}
    for name, one in each.items():
        values |= {name: one.value, f"{name}, low": one.low, f"{name}, high": one.high}
    there = [name for name, one in each.items() if one.low > LITTLE]
    if motion.effort == WITHOUT_FRICTION:
        if not there:
            return []
        shown = ", ".join(f"{name} {_percent(each[name])}" for name in there)
        finding = f"friction is left over; it takes of the power of {shown}"
        advice = (
            f"If the drive compensates none, read it with {ALL.option}; else identify with "
            "--model auto+fri, which learns what is left over"
        )
        return [Check(NAME, None, finding, False, advice, values, remedy=ALL)]
    none = [name for name, one in each.items() if one.high < LITTLE and one.low > -LITTLE]
    if there or 3 * len(none) < len(each):
        return []
    shown = ", ".join(f"{name} {_percent(each[name])}" for name in none)
    finding = (
        f"hardly any friction shows, on no joint surely; it takes of the power of {shown}. The "
        "drive compensates it, or the torque is sensed behind the gear: the two look the same"
    )
    advice = f"If so, give {FRICTIONLESS.option}: model and feedforward then leave it out"
    return [Check(NAME, None, finding, False, advice, values, remedy=FRICTIONLESS)]


def _percent(share: Estimate) -> str:
    return f"{share.value:.1%} [{share.low:.1%} to {share.high:.1%}]"


def effort_kind(motion: Motion, sliding: Sequence[int] = ()) -> EffortKind | None:
    """Return what the torques of a motion show; None if they do not suffice to fit an arm.

    Args:
        motion: of an arm's joints, from the base to the tool.
        sliding: indices of the joints that slide.
    """
    motion = decimated(motion)
    still = not (np.ptp(motion.tau, axis=0) > 0.0).any()
    if still or recorded_seconds(motion.time, motion.segment) < ENOUGH:
        return None
    x = Inputs.of(States(motion.q, motion.qd, motion.qdd), motion.time, motion.segment)
    spec = replace(parse(MODEL), sliding=tuple(sliding))

    def few(count: int) -> Samples:
        index = evenly(len(motion), count)
        step = usual_step(motion.time, motion.segment)
        most = min(AVERAGED / step, len(motion) / count) if step else 1.0
        window = max(1, 2 * int((most - 1.0) // 2) + 1)
        taken = x.take(index, window)
        return Samples(taken, taken.mean(motion.tau))

    whole = few(STAGES[-1][0])
    scaling = Scaling.of(whole.tau, per_joint=False)
    start = Problem.started(spec, whole, scaling)
    try:
        full = _maximised(start, few, STAGES)
        without = full.problem.having(kernel=full.problem.kernel.without_gravity())
        none = _maximised(
            start.having(kernel=start.kernel.without_gravity()), few, STAGES[1:], without
        )
        some = exact(_with_gravity(none.problem, HALF))
        friction = _friction(full, motion)
        turned = _turned(start, few, full, friction)
    except (ModelError, NotPositiveDefiniteError, np.linalg.LinAlgError):
        return None
    return EffortKind(
        motion.joints,
        max(full.log_evidence, some.log_evidence) - none.log_evidence,
        some.log_evidence - none.log_evidence,
        _gravity_share(full),
        friction,
        tuple(motion.joints[n] for n in turned),
    )


def _turned(
    start: Problem,
    few: Callable[[int], Samples],
    full: Posterior[System],
    friction: Sequence[Estimate],
) -> list[int]:
    """Return the joints that friction drives, and whose sign may be wrong by the evidence.

    Friction brakes. And the joints share one Lagrangian, so that the evidence falls where the signs
    of some and not of others are turned round wrongly.
    """
    turned = [n for n, one in enumerate(friction) if -ALL_POWER < one.high < -LITTLE]
    count = len(friction)

    def gain(joints: list[int]) -> float:
        sign = np.where(np.isin(np.arange(count), joints), -1.0, 1.0)

        def other(samples: Samples) -> Samples:
            return replace(samples, tau=samples.tau * sign)

        found = _maximised(start.of(other(start.samples)), lambda n: other(few(n)), STAGES)
        return found.log_evidence - full.log_evidence

    if not 1 < count == len(turned):
        return turned if turned and gain(turned) > -ABSENT else []
    # All turned round are as likely as none: is one of them more so?
    return turned if all(gain([n]) < ABSENT for n in turned) else []


def _maximised(
    start: Problem,
    few: Callable[[int], Samples],
    stages: tuple[tuple[int, int], ...],
    latest: Problem | None = None,
) -> Posterior[System]:
    """Return the posterior of largest evidence on the samples of the last stage.

    Args:
        start: the hyperprior is about its numbers.
        latest: to begin with; None is the start.
    """
    prior, problem = Logarithms(start).prior, latest or start
    for count, steps in stages:
        found = maximise_evidence(solvable(problem.of(few(count))), steps, prior, enough=0.5)
        problem = found.problem
    return found


def _with_gravity(problem: Problem, share: float) -> Problem:
    """Return the problem with gravity that is a share of each joint's torque, in the prior."""
    kernel = problem.kernel
    assert isinstance(kernel, Structured)
    states, tau = problem.samples.states, problem.samples.tau / problem.unit
    one = np.ones_like(kernel.potential)
    weight = np.mean(kernel.replace(potential=one).variance(states.at_rest()))
    size = share**2 * np.mean(np.var(tau, axis=0)) / weight
    return problem.having(kernel=kernel.replace(potential=size * one))


def _gravity_share(found: Posterior[System]) -> float:
    """Return the spread of gravity over that of the torque, of all joints together."""
    samples = found.problem.samples
    rigid = found.problem.kernel.learned(found.states, found.weights)
    gravity = rigid.torque(samples.states.at_rest()) * found.problem.unit
    return float(np.sqrt(np.var(gravity, axis=0).sum() / np.var(samples.tau, axis=0).sum()))


def _friction(found: Posterior[System], motion: Motion) -> tuple[Estimate, ...]:
    """Return the share of each joint's power that viscous and Coulomb friction take.

    The wider is taken of two deviations: the model's own, and the jackknife over blocks of time.
    """
    problem, system = found.problem, found.system
    samples = problem.samples
    power = np.mean(np.abs(samples.tau * samples.x.qd), axis=0)
    by_parameter = np.zeros((samples.tau.shape[1], problem.basis.size))
    for term, place in problem.basis.slices():
        if term.effect.plain and not term.effect.constant:
            speed = samples.x.qd[:, term.joint, None]
            taken = np.mean(term.columns(samples.x) * speed, axis=0)
            by_parameter[term.joint, place] = taken / (power[term.joint] or np.inf)
    value = by_parameter @ found.coefficients
    covariance = system.covariance * system.amplitude
    own = np.sqrt(np.einsum("nb,bc,nc->n", by_parameter, covariance, by_parameter))
    block = np.arange(len(samples)) * BLOCKS // len(samples)
    changed = found.changed(groups(block)) @ by_parameter.T
    spread = changed - changed.mean(axis=0)
    jackknife = np.sqrt((BLOCKS - 1) / BLOCKS * np.sum(spread**2, axis=0))
    reach = scipy.special.stdtrit(BLOCKS - 1, LEVEL) * np.maximum(own, jackknife)
    ends = zip(value.tolist(), (value - reach).tolist(), (value + reach).tolist(), strict=True)
    return tuple(Estimate(*three) for three in ends)
