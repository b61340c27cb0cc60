"""Predict what `diagnose` will see in a motion, before the arm has made it.

The search's problem is fitted once, to the model's own data: kernel, noise and units. A motion to
come is whitened with it, so that the search's own code gives the information A of every effect,
tempered as the effect's was on the model's data. With true coefficients b the signal is
s = ½ bᵀ A b. Without the effect, the search takes what is missing for noise, so that the evidence
grows by ½ ν log (1 + 2 s / ν): by s where the effect is small. ν is the number of samples over the
variance inflation.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis.excite.path import Reference
from lagrangian_ff.diagnosis.search.bayes_factor import (
    PRIOR_SHARE,
    BayesFactor,
    bayes_factors,
    expected,
    expected_log_bf,
)
from lagrangian_ff.diagnosis.search.candidates import Candidate, bends_over_speed, held, named
from lagrangian_ff.diagnosis.whitening import Whitened, fit_for, outweighed, whiten
from lagrangian_ff.diagnosis.whitening.hyperparameters import used
from lagrangian_ff.effects import Effect, Inputs, Parameter
from lagrangian_ff.effects.base import Values
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.problem import Problem
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.sampling import usual_step

SIZE = 0.05
"""Torque (rms) of an effect on the model's own data, over that of the joint, if none is given."""
SHAPES = 3
"""Shapes of an effect that stand for all of them."""

CREEPING = (0.5, 1.0)
"""Speeds, over that at which dry friction turns over, up to which its form is taken for unknown."""

Key = tuple[str, int]
Value = TypeVar("Value")


@dataclass(frozen=True)
class Expected:
    """The evidence that a motion is expected to give for an effect.

    Attributes:
        effect, joint: their names.
        size: torque (rms) of the effect on the model's own data, over that of the joint.
        torque: N·m (rms) of such an effect in this motion.
        signal: s, nats, were the noise known.  samples: ν.
        nats: the log Bayes factor expected at this size after all is refitted.

    Of several shapes all are the typical.
    """

    effect: str
    joint: str
    size: float
    torque: float
    signal: float
    samples: float
    nats: float

    def of_torque(self, torque: float) -> float:
        """Return the nats expected if the effect has another torque, N·m (rms), in this motion."""
        ratio = torque / self.torque if self.torque > 0.0 else 0.0
        price = refitted(self.signal, self.samples) - self.nats
        return max(float(refitted(ratio**2 * self.signal, self.samples) - price), 0.0)


class Creep(Effect):
    """Friction of any size below v_0, the speed over which the model's dry friction turns over.

    No model has its form there, and no arm follows a motion that slow. So an effect that shows at
    no higher speed is not told from it.
    """

    name = "creep"
    formula = "F_1 sign(qd) exp(-(2 qd / v_0)^2) + F_2 sign(qd) exp(-(qd / v_0)^2)"
    source = "this project"
    meaning = "friction while a joint creeps"
    parameters = tuple(
        Parameter(f"F_{n}", "N·m", f"friction up to about {share:g} v_0")
        for n, share in enumerate(CREEPING, start=1)
    )

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        slow = x.qd[:, [joint]] / (np.array(CREEPING) * x.sign_speed[joint])
        return np.asarray(x.sign(joint)[:, None] * np.exp(-(slow**2)))


def creeps(candidate: Candidate, x: Inputs) -> bool:
    """Return whether a bend of friction over speed hardly shows above creeping speed."""
    if not bends_over_speed(candidate.effect):
        return False
    span, _ = np.linalg.qr(Creep().columns(x, candidate.joint, {}))
    return held(candidate.columns(x), span)


@dataclass(frozen=True)
class Assumed:
    """The problem of the search, as fitted to the model's own data.

    Attributes:
        model: of the arm.
        base: the model's own data, whitened.
        problem: that of the search, for torques whose whitened variance is one.
        density: samples per s of motion that its noise is meant for.
        scores: of every effect on every joint on the base, in a few shapes each.
    """

    model: Model
    base: Whitened
    problem: Problem
    density: float
    scores: tuple[BayesFactor, ...]

    @classmethod
    def of(cls, model: Model, progress: Progress = silent, there: Sequence[Term] = ()) -> "Assumed":
        """Return the problem fitted to what the model keeps of its recordings.

        Args:
            there: what is there or looks like it: it makes up no noise.
        """
        data = model.data
        base = fit_for(model, data, Basis((*model.basis.terms, *there)), progress)
        base = outweighed(base) or base
        scores = bayes_factors(base, representative(base), coarse=True)
        base.forget()
        base = base.explaining(model.basis, base.problem.nuisance) if there else base
        density = _density(base.motion, len(base.index))
        return cls(model, base, _of_variance_one(base), density, tuple(scores))

    def unsure_of_creep(self, joints: Iterable[int]) -> "Assumed":
        """Return the same, with unknown friction of some joints while they creep: see `Creep`."""
        unknown = (Term(Creep(), joint) for joint in joints)
        basis = Basis((*self.problem.basis.terms, *unknown))
        return replace(self, problem=self.problem.having(basis=basis))

    def knowing(self, candidates: Iterable[Candidate]) -> "Assumed":
        """Return the same, with scores of what the catalogue lacks, such as formulas."""
        new = [one for one in candidates if one.key not in self.inflation]
        if not new:
            return self
        scores = bayes_factors(self.base, new, coarse=True)
        self.base.forget()
        return replace(self, scores=(*self.scores, *scores))

    @cached_property
    def inflation(self) -> Mapping[Key, float]:
        """Return by effect and joint the variance inflation on the base."""
        found = _by_key((one.candidate.key, one.variance_inflation) for one in self.scores)
        return {key: float(np.median(values)) for key, values in found.items()}

    def seen(self, size: float) -> Mapping[Key, float]:
        """Return by effect and joint the nats that the model's own data would show at a size."""
        one_size = np.array([size / PRIOR_SHARE])
        samples = len(self.base.index)
        found = _by_key((o.candidate.key, self._gain(o, one_size, samples)) for o in self.scores)
        return {key: typical(nats for _, nats in values) for key, values in found.items()}

    def suited_to(self, made: Reference) -> "Assumed":
        """Return the problem fitted to a motion to come, as the search will fit its recording.

        Kernel and noise are those of the torque that the model predicts, with white noise as large
        as on the base. The search knows an arm the better, the less it has moved.
        """
        motion = self.motion_of(made)
        noise = np.sqrt(self.base.x.window) * self.base.noise
        random = np.random.default_rng(0)
        motion = replace(motion, tau=motion.tau + noise * random.normal(size=motion.tau.shape))
        fitted = fit_for(self.model, motion)
        density = _density(motion, len(fitted.index))
        suited = replace(self, problem=_of_variance_one(fitted), density=density)
        unsure = (t.joint for t in self.problem.basis.terms if isinstance(t.effect, Creep))
        return suited.unsure_of_creep(unsure)

    def motion_of(self, made: Reference) -> Motion:
        """Return a motion to come, with the torque that the model predicts."""
        tau = self.model.predict(made.q, made.qd, made.qdd, time=made.time)
        segment = np.zeros(len(made.time), dtype=np.int64)
        held = self.model.data.conditioning
        return Motion(self.model.joints, *made, tau, segment, "a motion to come", (), held)

    def whitened(self, made: Reference) -> Whitened:
        """Return a motion to come as `diagnose` will whiten its recording."""
        motion = self.motion_of(made)
        return self.whitened_at(motion, used(motion), self.model.inputs_of(motion))

    def whitened_at(
        self, motion: Motion, index: Ints, inputs: Inputs, x: Inputs | None = None
    ) -> Whitened:
        """Return some samples of a motion whitened; those that look closer have more noise each.

        Args:
            motion: whose torques only give the spread.  index, inputs, x: see `whiten`.
        """
        noisier = self.problem.noisier(_density(motion, len(index)) / self.density)
        made = whiten(motion, index, self.base.seconds, inputs, noisier, x)
        # The torques have not been measured: the noise is what it was on the model's data.
        scale = 1.0 / np.sqrt(made.system.amplitude)
        target, white = scale * made.system.target, scale * made.system.white_target
        return replace(made, system=replace(made.system, target=target, white_target=white))

    def coefficients(self, candidate: Candidate, size: float) -> Floats:
        """Return (P,) the coefficients of an effect of a size, each as if it were the only one.

        Args:
            size: torque (rms) on the model's own data, over that of the joint.
        """
        rms = np.sqrt(np.mean(candidate.columns(self.base.x) ** 2, axis=0))
        torque = size * float(self.base.spread[candidate.joint])
        return np.asarray(torque / np.where(rms > 0.0, rms, np.inf))

    def gains(
        self, made: Reference, size: float = SIZE, candidates: Sequence[Candidate] = ()
    ) -> tuple[Expected, ...]:
        """Return what a motion is expected to show, of candidates or of every effect and joint."""
        whitened = self.whitened(made)
        samples, joints = len(whitened.index), self.model.joints
        pairs = []
        for score in bayes_factors(whitened, candidates or representative(self.base)):
            candidate = score.candidate
            columns, b = candidate.columns(whitened.x), self.coefficients(candidate, size)
            prior = expected(columns, float(whitened.spread[candidate.joint]))
            gain = self._gain(score, b / np.where(prior > 0.0, prior, np.inf), samples)
            torque = float(np.sqrt(np.mean((columns * b) ** 2)))
            pairs.append((candidate.key, (torque, *gain)))
        found = []
        for (name, n), values in _by_key(pairs).items():
            torque, signal, nats = map(typical, zip(*values, strict=True))
            count = samples / self.inflation[name, n]
            found.append(Expected(name, joints[n], size, torque, signal, count, nats))
        return tuple(found)

    def _gain(self, score: BayesFactor, ratio: Floats, samples: int) -> tuple[float, float]:
        """Return signal and nats of an effect whose coefficients are a ratio (P,) of the prior's.

        Each of them as if it were the only one, and the mean over them.
        """
        inflation = self.inflation[score.candidate.key]
        information = score.information / inflation
        signal = 0.5 * float(np.mean(np.diag(information) * ratio**2))
        nats = expected_log_bf(2.0 * float(refitted(signal, samples / inflation)), information)
        return signal, max(nats, 0.0)


def refitted(signal: Floats | float, samples: float) -> Floats:
    """Return ½ ν log (1 + 2 s / ν) of signals s and ν samples, nats."""
    return np.asarray(0.5 * samples * np.log1p(2.0 * np.asarray(signal) / samples))


def typical(nats: Iterable[float]) -> float:
    """Return the mean of some gains by their logarithms."""
    return float(np.expm1(np.mean(np.log1p(np.array(list(nats))))))


def _by_key(pairs: Iterable[tuple[Key, Value]]) -> dict[Key, list[Value]]:
    found: dict[Key, list[Value]] = {}
    for key, value in pairs:
        found.setdefault(key, []).append(value)
    return found


def representative(base: Whitened, keys: Iterable[Key] | None = None) -> list[Candidate]:
    """Return the effects that motion can show, of these names and joints, in a few shapes each."""
    every: dict[Key, list[Candidate]] = {}
    for one in named(base.x, base.basis, range(base.joints)):
        if one.effect.kind != "event":
            every.setdefault(one.key, []).append(one)
    wanted = every if keys is None else [key for key in keys if key in every]
    return [one for key in wanted for one in spread(every[key], SHAPES)]


def spread(candidates: Sequence[Candidate], most: int) -> list[Candidate]:
    """Return at most this many shapes of an effect, evenly spread, from inside the ends.

    Those of the joint's own gear come before those of others.
    """
    own = {s.name for one in candidates[:1] for s in one.effect.shapes if s.joint}
    mine = [c for c in candidates if all(c.shape.get(name) == c.joint for name in own)]
    candidates = mine or candidates
    if len(candidates) <= most:
        return list(candidates)
    places = (np.arange(most) + 0.5) * len(candidates) / most
    return [candidates[int(place)] for place in places]


def _of_variance_one(whitened: Whitened) -> Problem:
    """Return the problem with units for which the whitened torques have a variance of one."""
    scaling = whitened.problem.prior.scaling
    scaling = replace(scaling, unit=scaling.unit * whitened.amplitude)
    return replace(whitened.problem.having(scaling=scaling), nuisance=(), change=None)


def _density(motion: Motion, samples: int) -> float:
    moves = int(np.sum(~motion.rest.all(axis=1)))
    return samples / max(moves * usual_step(motion.time, motion.segment), 1e-9)
