"""Choosing the prior and the friction's shapes by evidence, on few samples first."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from threadpoolctl import threadpool_limits

from lagrangian_ff.diagnosis.ground.ground import Extra, Ground, factored, lay, window_of
from lagrangian_ff.diagnosis.ground.prior import Prior
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

ROWS = 4800
"""Torques (samples times joints) that a ground is laid on: a factor takes about a second."""
COARSE, FINE, SHAPES = 120, 240, 400
"""Few samples find the way. Judged on few alone, a flexible prior takes the noise for dynamics."""
BLOCK_SECONDS = 2.0
COARSE_SWEEPS, FINE_SWEEPS = 4, 3
GAIN_WORTH = 100.0
"""Nats that other units of effort must be worth before they are believed."""
LEAST_NOISE = 1e-7
"""Of the prior variance, the least noise: with less, a ground of many samples has no factor."""
FAILED = 1e12
SIGN_SPEEDS = np.geomspace(0.002, 0.3, 28)  # rad/s


def tune(motion: Motion, inputs: Inputs, basis: Basis, progress: Progress = silent) -> Ground:
    """Lay the ground of a motion, everything about it chosen by evidence.

    Args:
        motion: measured, at 100 Hz or so.
        inputs: the same motion with the model's load and torque.
        basis: the effects already in the model; the width of their Coulomb step is chosen anew.
        progress: told the share done.
    """
    prior = Prior.start(motion.tau)
    with threadpool_limits(1):
        coarse = evidence_of(motion, inputs, basis, COARSE)
        prior = _search(coarse, prior, COARSE_SWEEPS, 1.0, part(progress, 0.0, 0.1))
        fine = evidence_of(motion, inputs, basis, FINE)
        prior = _search(fine, prior, FINE_SWEEPS, 0.7, part(progress, 0.1, 0.5))
        basis = _sign_speeds(motion, inputs, basis, prior)
        inputs = replace(inputs, sign_speed=basis.sign_speed(inputs.joints))
        fine = evidence_of(motion, inputs, basis, FINE)
        prior = _search(fine, prior, FINE_SWEEPS, 0.5, part(progress, 0.5, 0.7))
        basis = _sign_speeds(motion, inputs, basis, prior)
        inputs = replace(inputs, sign_speed=basis.sign_speed(inputs.joints))
        prior = _gains(motion, inputs, basis, prior)
    progress(0.8, "factoring")
    ground = _lay(motion, inputs, basis, prior)
    inputs = ground.inputs_of(motion)
    ground = replace(ground, inputs=inputs)
    if any(term.effect.uses for term in basis.terms):
        ground = _lay(motion, inputs, basis, prior)
    progress(0.9, "predicting the load")
    ground = replace(ground, seen=ground.unseen_inputs())
    progress(1.0, "predicting the load")
    return ground


def sharpen(
    ground: Ground, basis: Basis, extra: tuple[Extra, ...] = (), progress: Progress = silent
) -> Prior:
    """The prior chosen anew with more explained: what is left then stands out more."""
    evidence = evidence_of(ground.motion, ground.inputs, basis, FINE, extra, ground)
    with threadpool_limits(1):
        return _search(evidence, ground.prior, 2, 0.7, progress)


def _lay(motion: Motion, inputs: Inputs, basis: Basis, prior: Prior) -> Ground:
    index = evenly(len(motion), ROWS // len(motion.joints))
    return lay(motion, index, motion.blocks(BLOCK_SECONDS)[index], inputs, prior, basis)


def _window(motion: Motion) -> int:
    """As the ground will have it, so that the noise is of the same kind."""
    return window_of(evenly(len(motion), ROWS // len(motion.joints)), motion)


def evidence_of(
    motion: Motion, inputs: Inputs, basis: Basis, samples: int, extra: tuple[Extra, ...] = (),
    ground: Ground | None = None,
) -> Callable[[Prior], float]:  # fmt: skip
    """The log evidence in N·m of some of the samples, as a function of the prior."""
    if ground is None:
        index = evenly(len(motion), samples)
        x = inputs.take(index, _window(motion))
    else:
        chosen = evenly(len(ground.index), samples)
        index = ground.index[chosen]
        x = ground.seen.take(chosen)
        extra = tuple(Extra(one.joint, one.columns[chosen]) for one in extra)
    tau = x.mean(motion.tau)
    states = States(x.q, x.qd, x.qdd)

    def evidence(prior: Prior) -> float:
        if np.any(prior.noise < LEAST_NOISE * prior.kernel.variance(states).mean()):
            return -FAILED
        try:
            system = factored(tau, x, prior, basis, extra)
        except NotPositiveDefiniteError:
            return -FAILED
        return system.log_evidence - len(index) * float(np.sum(np.log(prior.unit)))

    return evidence


def _search(
    evidence: Callable[[Prior], float], prior: Prior, sweeps: int, step: float, progress: Progress
) -> Prior:
    """Coordinate by coordinate uphill: cheaper than a simplex where the numbers are many."""
    point = prior.vector()
    best = evidence(prior)
    steps = np.full(len(point), step)
    for sweep in range(sweeps):
        for axis in range(len(point)):
            progress((sweep + axis / len(point)) / sweeps, "choosing the noise and the prior")
            for sign in (1.0, -1.0):
                tried = point.copy()
                tried[axis] += sign * steps[axis]
                value = evidence(prior.at(tried))
                if value > best:
                    best, point = value, tried
                    steps[axis] *= 1.3 * sign
                    break
            else:
                steps[axis] *= 0.5
    return prior.at(point)


def _gains(motion: Motion, inputs: Inputs, basis: Basis, prior: Prior) -> Prior:
    """Units of effort that differ between joints, where the evidence for that is strong."""
    evidence = evidence_of(motion, inputs, basis, COARSE)
    first = evidence(prior)
    best, gain = first, prior.gain
    steps = np.full(len(gain), 0.25)
    for _ in range(3):
        for joint in range(1, len(gain)):
            for sign in (1.0, -1.0):
                tried = gain.copy()
                tried[joint] *= np.exp(sign * steps[joint])
                value = evidence(prior.with_gain(tried))
                if value > best:
                    best, gain = value, tried
                    break
            else:
                steps[joint] *= 0.4
    return prior.with_gain(gain) if best - first > GAIN_WORTH else prior


def _sign_speeds(motion: Motion, inputs: Inputs, basis: Basis, prior: Prior) -> Basis:
    """The width of each joint's Coulomb step: a wrong one looks like a bump at low speed."""
    places = [
        (number, place.start)
        for number, (term, place) in enumerate(basis.slices())
        if term.effect.name == "coulomb"
    ]
    if not places:
        return basis
    index = evenly(len(motion), SHAPES)
    x = inputs.take(index, _window(motion))
    system = factored(x.mean(motion.tau), x, prior, basis)
    white = system.white_design.copy()
    terms = list(basis.terms)
    for number, column in places:
        term = terms[number]
        tried = np.zeros((len(index), x.joints, len(SIGN_SPEEDS)))
        unit = prior.unit[term.joint]
        for k, speed in enumerate(SIGN_SPEEDS):
            tried[:, term.joint, k] = x.mean(np.tanh(inputs.qd[:, term.joint] / speed)) / unit
        flat = tried.reshape(-1, len(SIGN_SPEEDS))
        z = solve_triangular(system.upper, flat, trans=1, check_finite=False)
        span, _ = np.linalg.qr(np.delete(white, column, axis=1))
        left = system.white_target - span @ (span.T @ system.white_target)
        z -= span @ (span.T @ z)
        fall = (z.T @ left) ** 2 / np.maximum(np.sum(z * z, axis=0), 1e-300)
        speed = float(np.exp(_peak(np.log(SIGN_SPEEDS), fall)))
        terms[number] = Term(term.effect, term.joint, {**term.shape, "v0": speed})
        chosen = np.zeros((len(index), x.joints))
        chosen[:, term.joint] = x.mean(np.tanh(inputs.qd[:, term.joint] / speed)) / unit
        white[:, column] = solve_triangular(
            system.upper, chosen.ravel(), trans=1, check_finite=False
        )
    return Basis(tuple(terms))


def _peak(at: Floats, values: Floats) -> float:
    """Where a parabola through the largest of evenly spaced values and its neighbours peaks."""
    k = int(np.argmax(values))
    if not 0 < k < len(values) - 1:
        return float(at[k])
    before, here, after = values[k - 1 : k + 2]
    bend = before - 2.0 * here + after
    shift = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    return float(at[k] + shift * (at[1] - at[0]))
