"""Choosing the prior and the friction's shapes by evidence, on few samples first."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from threadpoolctl import threadpool_limits

from lagrangian_ff.diagnosis.ground.ground import Extra, Ground, factored, lay, window_of
from lagrangian_ff.diagnosis.ground.prior import Prior
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.choosing.ascent import Hill, Slopes, slopes_by_gram
from lagrangian_ff.identification.choosing.belief import Belief
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.sliding import sliding_of
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

ROWS = 4800
"""Torques (samples times joints) that a ground is laid on: a factor takes about a second."""
COARSE, FINE, SHAPES = 120, 240, 400
"""Few samples find the way. Judged on few alone, a flexible prior takes the noise for dynamics."""
BLOCK_SECONDS = 2.0
STAGES = ((60, 20), (COARSE, 6), (FINE, 2))
"""Samples the evidence is climbed with, and steps at most."""
AGAIN = 2
"""Steps at most, where little has changed."""
GAIN_WORTH = 100.0
"""Nats that other units of effort must be worth before they are believed."""
LEAST_NOISE = 1e-7
"""Of the prior variance, the least noise: with less, a ground of many samples has no factor."""
FAILED = 1e12
SIGN_SPEEDS = np.geomspace(0.002, 0.3, 28)  # rad/s


def tune(
    motion: Motion, inputs: Inputs, basis: Basis, progress: Progress = silent,
    sliding: Floats | None = None,
) -> Ground:  # fmt: skip
    """Lay the ground of a motion, everything about it chosen by evidence.

    Args:
        motion: measured, at 100 Hz or so.
        inputs: the same motion with the model's load and torque.
        basis: the effects already in the model; the width of their Coulomb step is chosen anew.
        progress: told the share done.
        sliding: (N,) 1 where a joint slides; None where all turn.
    """
    index = evenly(len(motion), FINE)
    states = States(inputs.q[index], inputs.qd[index], inputs.qdd[index])
    prior = Prior.start(motion.tau, states, sliding)
    middle = prior.vector()
    with threadpool_limits(1):
        begin = 0.0
        for (samples, steps), end in zip(STAGES, (0.1, 0.3, 0.5), strict=True):
            some = part_of(motion, inputs, samples)
            prior = _climb(some, basis, prior, middle, steps, part(progress, begin, end))
            begin = end
        basis = _sign_speeds(motion, inputs, basis, prior)
        inputs = replace(inputs, sign_speed=basis.sign_speed(inputs.joints))
        fine = part_of(motion, inputs, FINE)
        prior = _climb(fine, basis, prior, middle, AGAIN, part(progress, 0.5, 0.7))
        basis = _sign_speeds(motion, inputs, basis, prior)
        inputs = replace(inputs, sign_speed=basis.sign_speed(inputs.joints))
        prior = _gains(motion, inputs, basis, prior)
    progress(0.8, "factoring")
    ground = _lay(motion, inputs, basis, prior)
    inputs = ground.inputs_of(motion)
    ground = replace(ground, inputs=inputs)
    if any(term.effect.uses for term in basis.terms):
        ground = _lay(motion, inputs, basis, prior, ground.system)
    progress(0.9, "predicting the load")
    ground = replace(ground, seen=ground.unseen_inputs())
    progress(1.0, "predicting the load")
    return ground


def sharpen(
    ground: Ground,
    basis: Basis,
    extra: tuple[Extra, ...] = (),
    progress: Progress = silent,
    prior: Prior | None = None,
) -> Prior:
    """The prior chosen anew with more explained: what is left then stands out more.

    Args:
        ground: of the motion.
        basis, extra: what is explained.
        progress: told the share done.
        prior: where to begin; None: with that of the ground.
    """
    prior = prior or ground.prior
    some = part_of(ground.motion, ground.inputs, FINE, extra, ground)
    states = States(some.x.q, some.x.qd, some.x.qdd)
    sliding = sliding_of(prior.kernel, ground.joints)
    middle = Prior.start(some.tau, states, sliding).vector()
    with threadpool_limits(1):
        return _climb(some, basis, prior, middle, AGAIN, progress)


def _lay(
    motion: Motion, inputs: Inputs, basis: Basis, prior: Prior, like: System | None = None
) -> Ground:
    index = evenly(len(motion), ROWS // len(motion.joints))
    block = motion.blocks(BLOCK_SECONDS)[index]
    return lay(motion, index, block, inputs, prior, basis, like=like)


def _window(motion: Motion) -> int:
    """As the ground will have it, so that the noise is of the same kind."""
    return window_of(evenly(len(motion), ROWS // len(motion.joints)), motion)


@dataclass(frozen=True)
class Part:
    """Some of the samples, on which a prior is judged.

    Attributes:
        x: (S,) as effects see them.  tau: (S, N) N·m.
        extra: what is explained away besides the basis.
    """

    x: Inputs
    tau: Floats
    extra: tuple[Extra, ...] = ()

    def system(self, prior: Prior, basis: Basis, like: System | None = None) -> System:
        """These samples, factored, or with the factor of a system like theirs.

        Raises:
            NotPositiveDefiniteError: the noise is too small for the arithmetic, here or where
                there are more samples.
        """
        variance = prior.kernel.variance(States(self.x.q, self.x.qd, self.x.qdd)).mean()
        if np.any(prior.noise < LEAST_NOISE * variance):
            raise NotPositiveDefiniteError("too little noise for a ground of many samples")
        return factored(self.tau, self.x, prior, basis, self.extra, like)


def part_of(
    motion: Motion, inputs: Inputs, samples: int, extra: tuple[Extra, ...] = (),
    ground: Ground | None = None,
) -> Part:  # fmt: skip
    """Some samples of a motion, evenly spread; or some of those of a ground."""
    if ground is None:
        x = inputs.take(evenly(len(motion), samples), _window(motion))
    else:
        chosen = evenly(len(ground.index), samples)
        x = ground.seen.take(chosen)
        extra = tuple(Extra(one.joint, one.columns[chosen]) for one in extra)
    return Part(x, x.mean(motion.tau), extra)


def _climb(
    some: Part, basis: Basis, prior: Prior, middle: Floats, steps: int, progress: Progress
) -> Prior:
    """Up the evidence from a prior; `middle` is where its logarithms are believed to be."""
    states = States(some.x.q, some.x.qd, some.x.qdd)

    def go(point: Floats) -> tuple[Prior, System]:
        at = prior.at(point)
        return at, some.system(at, basis)

    def slopes(stand: tuple[Prior, System]) -> Slopes:
        at, system = stand
        return slopes_by_gram(system, at.kernel, states, at.noise, at.second(some.x))

    hill = Hill(Belief(middle), go, lambda stand: stand[1].log_evidence, slopes)
    try:
        point, _ = hill.climb(
            prior.vector(), steps, lambda step: progress(step / steps, "climbing the evidence")
        )
    except NotPositiveDefiniteError:
        return prior
    return prior.at(point)


def _gains(motion: Motion, inputs: Inputs, basis: Basis, prior: Prior) -> Prior:
    """Units of effort that differ between joints, where the evidence for that is strong."""
    evidence = _by_gain(part_of(motion, inputs, COARSE), basis, prior)
    first = evidence(prior.gain)
    best, gain = first, prior.gain
    steps = np.full(len(gain), 0.25)
    for _ in range(3):
        for joint in range(1, len(gain)):
            for sign in (1.0, -1.0):
                tried = gain.copy()
                tried[joint] *= np.exp(sign * steps[joint])
                value = evidence(tried)
                if value > best:
                    best, gain = value, tried
                    break
            else:
                steps[joint] *= 0.4
    return prior.with_gain(gain) if best - first > GAIN_WORTH else prior


def _by_gain(some: Part, basis: Basis, prior: Prior) -> Callable[[Floats], float]:
    """The log evidence in N·m as a function of the units; they change no Gram matrix."""
    try:
        system = some.system(prior, basis)
    except NotPositiveDefiniteError:
        return lambda gain: -FAILED
    joints = len(prior.unit)
    apart = (system.target.reshape(-1, joints, 1) * np.eye(joints)).reshape(-1, joints)
    white = solve_triangular(system.upper, apart, trans=1, check_finite=False)

    def evidence(gain: Floats) -> float:
        unit = prior.with_gain(gain).unit
        scale = prior.unit / unit
        scaled = replace(
            system,
            white_design=system.white_design * scale[basis.joints],
            white_target=white @ scale,
        )
        return scaled.log_evidence - len(some.x) * float(np.sum(np.log(unit)))

    return evidence


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
