"""Fit hyperparameters and the shapes of friction by evidence, on few samples first."""

from collections.abc import Collection
from dataclasses import replace
from itertools import compress

import numpy as np
from scipy.linalg import solve_triangular

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.whitening.blocks import LONGEST, block_seconds
from lagrangian_ff.diagnosis.whitening.errors import errors_of_shapes
from lagrangian_ff.diagnosis.whitening.whitened import AVERAGED, Whitened, whiten, window_of
from lagrangian_ff.effects import Inputs
from lagrangian_ff.effects.inputs import SIGN_SPEED
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.choosing.evidence import Logarithms, loud, maximise_evidence
from lagrangian_ff.identification.choosing.gains import gains_of, likeliest_gains
from lagrangian_ff.identification.choosing.levenberg_marquardt import HyperPrior
from lagrangian_ff.identification.problem import Nuisance, Prior, Problem, Scaling
from lagrangian_ff.identification.samples import Samples, evenly, moving
from lagrangian_ff.identification.solving.posterior import exact
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.identification.spec import sliding_of
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.structured.chain import Chain
from lagrangian_ff.kernels.threads import one_blas_thread
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording.motion import WITHOUT_GRAVITY, Motion
from lagrangian_ff.sampling import usual_step

COARSE, FINE, SHAPES = 120, 240, 400
"""Numbers of samples. On the fewest alone, a flexible prior takes the noise for dynamics."""
AGAIN = 2
"""Largest number of steps of a refit."""
FEWEST = 200
"""Samples that are whitened at least, however low the low-pass."""
CLOSELY = 0.5
"""Share of the samples that are whitened, which may be of what is looked at closely."""
LEAST_NOISE = 1e-7
"""Least noise relative to the prior variance; with less, many samples have no factor."""
FAILED = 1e12
SIGN_SPEEDS = np.geomspace(0.002, 0.3, 28)  # rad/s
SIGN_SPREAD = 1.0
"""Standard deviation of their logarithm about `SIGN_SPEED`, before anything is known."""
HELD = 0.05
"""Share of the speed of the fastest joint below which a joint counts as held, before the fit."""
START_NOISE = 1e-2
"""Variance of the noise relative to the prior's, before the fit."""


def fit_for(
    model: Model, motion: Motion, basis: Basis | None = None, progress: Progress = silent
) -> Whitened:
    """Return a motion of a model's arm whitened, see `fit`.

    Args:
        basis: the effects already in the model; None takes them all.
    """
    sliding = sliding_of(model.kernel, len(model.joints))
    basis = model.basis if basis is None else basis
    return fit(motion, model.inputs_of(motion), basis, progress, sliding, model.unit)


def fit(
    motion: Motion,
    inputs: Inputs,
    basis: Basis,
    progress: Progress = silent,
    sliding: Floats | None = None,
    unit: Floats | None = None,
) -> Whitened:
    """Return a motion whitened, with all hyperparameters fitted by evidence.

    Args:
        motion: measured, at 100 Hz or so.
        inputs: the same motion with the model's load and torque.
        basis: the effects already in the model; the widths of their Coulomb steps are refitted.
        progress: receives the share done, 0 to 1.
        sliding: (N,) 1 for a joint that slides; None if all turn.
        unit: (N,) N·m, of effort that the model was identified with; None if that is not known.
    """
    index = moving(motion, FINE)
    states = States(inputs.q[index], inputs.qd[index], inputs.qdd[index])
    weightless = motion.effort == WITHOUT_GRAVITY
    few = _few(motion, inputs, FINE)
    problem = _started(few, motion.tau, states, basis, sliding, weightless)
    prior = _about(problem)
    with one_blas_thread():
        begin = 0.0
        for (count, steps), end in zip(thresholds.EFFORT.stages, (0.1, 0.3, 0.5), strict=True):
            problem = problem.of(_few(motion, inputs, count))
            problem = _maximised(problem, prior, steps, part(progress, begin, end))
            begin = end
        problem = _sign_speeds(motion, inputs, problem)
        inputs = replace(inputs, sign_speed=problem.basis.sign_speed(inputs.joints))
        problem = problem.of(_few(motion, inputs, FINE))
        problem = _maximised(problem, prior, AGAIN, part(progress, 0.5, 0.7))
        problem = _sign_speeds(motion, inputs, problem)
        inputs = replace(inputs, sign_speed=problem.basis.sign_speed(inputs.joints))
        problem = _with_gains(problem.of(_few(motion, inputs, COARSE)), unit)
    progress(0.8, "factoring")
    whitened = _whitened(motion, inputs, problem, used(motion))
    inputs = whitened.inputs_of(motion)
    whitened = replace(whitened, inputs=inputs)
    if any(term.effect.uses for term in problem.basis.terms):
        whitened = _whitened(motion, inputs, problem, whitened.index, whitened.system)
    progress(0.9, "predicting the load")
    samples = replace(whitened.problem.samples, x=whitened.inputs_left_out())
    progress(1.0, "predicting the load")
    return replace(whitened, problem=whitened.problem.of(samples))


def refit(
    whitened: Whitened,
    basis: Basis,
    nuisance: tuple[Nuisance, ...] = (),
    change: tuple[float, float, float] | None = None,
) -> Problem:
    """Return the problem with hyperparameters refitted while more is explained.

    Args:
        basis, nuisance: the effects and the columns that are explained.
        change: instead of that of the problem; None keeps that one.
    """
    change = change or whitened.problem.change
    whole = replace(whitened.problem.having(basis=basis), nuisance=nuisance, change=change)
    problem = whole.thinned(FINE)
    samples = problem.samples
    sliding = sliding_of(problem.kernel, whitened.joints)
    weightless = whitened.motion.effort == WITHOUT_GRAVITY
    start = _started(samples, samples.tau, samples.states, basis, sliding, weightless)
    with one_blas_thread():
        return _maximised(problem, _about(start), AGAIN, silent)


def _started(
    samples: Samples,
    tau: Floats,
    states: States,
    basis: Basis,
    sliding: Floats | None,
    weightless: bool,
) -> Problem:
    """Return the problem before the fit.

    Args:
        tau: (M, N) N·m and states: (M, N) give the scales.
        basis: the effects already in the model.
        sliding: (N,) 1 for a joint that slides; None if all turn.
        weightless: whether the torque holds no gravity.
    """
    spread = np.std(tau, axis=0)
    unit = spread.max(initial=0.0) or 1.0
    share = np.maximum(spread / unit, 1e-4) ** 2
    kernel = Chain.start(states)
    # A joint that is held trembles: scaled to that, its inertia would outweigh all others'.
    kernel = kernel.replace(inertia=np.minimum(kernel.inertia, kernel.inertia.min() / HELD**2))
    if sliding is not None:
        kernel = kernel.replace(prismatic=sliding)
    if weightless:
        kernel = kernel.without_gravity()
    relative = np.maximum(START_NOISE * share, 2.0 * LEAST_NOISE)
    noise = relative * kernel.variance(states).mean()
    scaling = Scaling(np.full(tau.shape[1], unit), np.ones(tau.shape[1]))
    return Problem(samples, Prior(kernel, noise, scaling, basis))


def _about(problem: Problem) -> HyperPrior:
    """Return the hyperprior centred on the hyperparameters of a problem."""
    return HyperPrior(Logarithms(problem, shapes=False).of(problem))


def _few(motion: Motion, inputs: Inputs, count: int) -> Samples:
    """Return some samples of a motion, averaged as all of them are."""
    x = inputs.take(moving(motion, count), window_of(used(motion), motion))
    return Samples(x, x.mean(motion.tau))


def used(motion: Motion) -> Ints:
    """Return the samples (S,) of a motion that are whitened.

    Not more than the low-pass has left independent: two in each period of its bandwidth. Of what is
    to be looked at closely nothing is left out that moves, if that takes no more than `CLOSELY` of
    all samples.
    """
    bandwidth = motion.conditioning.get("bandwidth")
    most = thresholds.EFFORT.rows // len(motion.joints)
    step = usual_step(motion.time, motion.segment)
    if isinstance(bandwidth, float):
        most = min(most, max(FEWEST, round(2.0 * bandwidth * len(motion) * step)))
    if motion.closely is None:
        return moving(motion, most)
    every = moving(motion, len(motion))
    if len(every) * step <= most * AVERAGED:
        return every[evenly(len(every), most)]
    near, rest = every[motion.closely[every]], every[~motion.closely[every]]
    count = min(round(len(near) * step / AVERAGED), round(CLOSELY * most))
    count = max(count, most - len(rest))
    parts = near[evenly(len(near), count)], rest[evenly(len(rest), most - count)]
    return np.sort(np.concatenate(parts))


def _whitened(
    motion: Motion, inputs: Inputs, problem: Problem, index: Ints, like: System | None = None
) -> Whitened:
    made = whiten(motion, index, LONGEST, inputs, problem, like=like)
    return replace(made, seconds=block_seconds(made))


def _maximised(problem: Problem, prior: HyperPrior, steps: int, progress: Progress) -> Problem:
    """Return the problem with the hyperparameters of largest evidence; unchanged if that fails."""
    try:
        return maximise_evidence(
            problem, steps, prior, progress, shapes=False, least_noise=LEAST_NOISE
        ).problem
    except NotPositiveDefiniteError:
        return problem


def _with_gains(problem: Problem, unit: Floats | None) -> Problem:
    """Return the problem with units of effort that differ between joints, if evident.

    Those of the model need less: torques that it lacks can look like other units, but the arm that
    it was identified on had the same drives.
    """
    limits, clear = thresholds.USED, loud(problem, LEAST_NOISE)
    try:
        if unit is not None:
            known = gains_of(clear, unit)
            if known.nats > limits.known_unit_floor:
                return known.of(problem)
        gains = likeliest_gains(clear)
    except NotPositiveDefiniteError:
        return problem
    return problem if gains.nats <= limits.unit_floor else gains.of(problem)


def with_sign_speeds(whitened: Whitened, joints: Collection[int]) -> Whitened:
    """Return the motion with the widths of some joints' Coulomb steps fitted beside all effects.

    A width that was fitted while other friction was missing had made up for it. What an error of
    that width would add is no part of the fit: beside it, any width near it does.
    """
    problem = whitened.problem
    others = Basis(tuple(term for term in problem.basis.terms if not term.effect.sign_width))
    nuisance = (*problem.nuisance, *errors_of_shapes(others, whitened.x))
    system = exact(replace(problem, nuisance=nuisance), like=whitened.system).system
    basis = _with_widths(problem, whitened.x, system, joints)
    speed = basis.sign_speed(whitened.joints)
    inputs, x = _with_signs(whitened.inputs, speed), _with_signs(whitened.x, speed)
    parts = whitened.motion, whitened.index, whitened.seconds, inputs
    weighted = x, whitened.system, problem.samples.weight
    return whiten(*parts, problem.having(basis=basis), *weighted, lagging=whitened.lagging)


def _sign_speeds(motion: Motion, inputs: Inputs, problem: Problem) -> Problem:
    """Return the problem with the width of each joint's Coulomb step fitted on few samples."""
    if not any(term.effect.sign_width for term in problem.basis.terms):
        return problem
    some = problem.of(_few(motion, inputs, SHAPES))
    widths = _with_widths(some, some.samples.x, exact(some).system, range(inputs.joints))
    return problem.having(basis=widths)


def _with_widths(problem: Problem, x: Inputs, system: System, joints: Collection[int]) -> Basis:
    """Return the basis with the likeliest widths of some joints' Coulomb steps.

    A wrong width looks like a bump at low speed. All friction of the joint takes its sign from it:
    beside hysteresis that kept the old one, no other width would fit.

    Args:
        x: the samples of the problem.  system: of the problem.
    """
    basis, white = problem.basis, system.white_design.copy()
    # Where a joint never creeps any width does: as wide as all speeds, the step is a bent line.
    likely = -0.5 * (np.log(SIGN_SPEEDS / SIGN_SPEED) / SIGN_SPREAD) ** 2

    def columns(friction: Basis) -> Floats:
        """Return (S N, B) the normalised columns of a joint's friction."""
        signs = _with_signs(x, friction.sign_speed(x.joints))
        return (friction.design(signs) / problem.unit[:, None]).reshape(-1, friction.size)

    def whitened(flat: Floats) -> Floats:
        return np.asarray(solve_triangular(system.upper, flat, trans=1, check_finite=False))

    for joint in (t.joint for t in basis.terms if t.effect.sign_width and t.joint in joints):
        rubs = [t.joint == joint and t.effect.kind == "friction" for t in basis.terms]
        friction = Basis(tuple(compress(basis.terms, rubs)))
        places = np.concatenate([np.r_[place] for _, place in compress(basis.slices(), rubs)])
        span, _ = np.linalg.qr(np.delete(white, places, axis=1))
        left = system.white_target - span @ (span.T @ system.white_target)
        tried = [columns(_as_wide(friction, joint, speed)) for speed in SIGN_SPEEDS.tolist()]
        z = whitened(np.hstack(tried))
        z -= span @ (span.T @ z)
        directions = (np.linalg.qr(one)[0] for one in np.split(z, len(tried), axis=1))
        rest = [left @ left - np.sum((one.T @ left) ** 2) for one in directions]
        nats = likely - 0.5 * len(left) * np.log(rest)
        basis = _as_wide(basis, joint, float(np.exp(_peak(np.log(SIGN_SPEEDS), nats))))
        white[:, places] = whitened(columns(Basis(tuple(compress(basis.terms, rubs)))))
    return basis


def _as_wide(basis: Basis, joint: int, speed: float) -> Basis:
    """Return the basis with this width of a joint's Coulomb step, rad/s."""
    return Basis(
        tuple(
            replace(t, shape={**t.shape, t.effect.sign_width: speed})
            if t.joint == joint and t.effect.sign_width
            else t
            for t in basis.terms
        )
    )


def _with_signs(x: Inputs, speed: Floats) -> Inputs:
    """Return the inputs with these widths (N,) of the smoothed signs, rad/s."""
    whole = None if x.whole is None else replace(x.whole, sign_speed=speed)
    return replace(x, sign_speed=speed, whole=whole)


def _peak(at: Floats, values: Floats) -> float:
    """Return where a parabola through the largest of evenly spaced values peaks."""
    k = int(np.argmax(values))
    if not 0 < k < len(values) - 1:
        return float(at[k])
    before, here, after = values[k - 1 : k + 2]
    bend = before - 2.0 * here + after
    shift = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    return float(at[k] + shift * (at[1] - at[0]))
