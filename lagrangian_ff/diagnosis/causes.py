"""Single causes of a change from a boundary of time on: a gain, friction of a joint, the bodies.

They compete by log evidence, each with all that it does at once: another gain of a drive scales
the friction of its joint too, a load adds to the torque of all joints before it.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.arrays import Flags, Floats
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.intervals import gain_reach, reach
from lagrangian_ff.diagnosis.search.bayes_factor import (
    PRIOR_SHARE,
    expected,
    tempered_log_bf,
    variance_inflation_of,
)
from lagrangian_ff.diagnosis.whitening import Whitened, refit
from lagrangian_ff.identification.problem import Nuisance
from lagrangian_ff.identification.solving.posterior import exact

LOG_GAIN = 0.3
"""Standard deviation a priori of the logarithm of a gain's change."""
GRID = 2001
"""Logarithms of a gain that are tried, from a fifth to five times."""


@dataclass(frozen=True)
class Linear:
    """A change that is linear in its parameters, fitted.

    Attributes:
        log_bf: nats, tempered.  evidence: nats, with the noise that suits it, to compare causes.
        values: (P,) the parameters.
        learned: (P,) whether the motion says anything of them.
        torque: (S, N) N·m that it adds.
    """

    log_bf: float
    evidence: float
    values: Floats
    learned: Flags
    torque: Floats

    def half(self, whitened: Whitened, columns: Floats, unknown: Floats) -> Floats:
        """Return (P,) half the width of the parameters' 90 % intervals.

        Args:
            whitened, columns: as they were fitted.
            unknown: (N,) relative errors of the drives' gains, see `gain_reach`.
        """
        scale, white = _white(whitened, columns)
        z = np.sum(white, axis=0)
        covariance = np.linalg.inv(z.T @ z + np.eye(len(scale)))
        fitted = covariance @ (z.T @ whitened.residual)
        half = reach(whitened, z, whitened.residual - z @ fitted, covariance)
        parts = [covariance @ (z.T @ (one @ fitted)) for one in white]
        return np.asarray(np.hypot(half, gain_reach(parts, unknown)) * scale)


def _white(whitened: Whitened, columns: Floats) -> tuple[Floats, list[Floats]]:
    """Return (P,) the prior scale of columns (S, N, P), and for each joint (n, P) them whitened."""
    share = np.sqrt(np.mean(columns**2, axis=0)) / whitened.spread[:, None]
    largest = share.max(axis=0)
    scale = PRIOR_SHARE / np.where(largest > 0.0, largest, np.inf)
    every = range(whitened.joints)
    white = [whitened.whitened(columns[:, n] * scale, n) for n in every]
    return scale, [whitened.project(one) for one in white]


def linear(whitened: Whitened, columns: Floats) -> Linear:
    """Return a change of the torques, (S, N, P) N·m per unit of each parameter, fitted."""
    scale, white = _white(whitened, columns)
    z, w = np.sum(white, axis=0), whitened.residual
    information, sums = z.T @ z, z.T @ w
    covariance = np.linalg.inv(information + np.eye(len(sums)))
    fitted = covariance @ sums
    left = w - z @ fitted
    rest = np.add.reduceat(z * left[:, None], whitened.starts, axis=0)
    inflation = float(variance_inflation_of(rest.ravel(), float(np.trace(information))))
    log_bf = float(tempered_log_bf(sums[None, :], information, inflation)[0])
    degrees = whitened.system.degrees
    fall = min(float(sums @ fitted) / degrees, 1.0 - 1e-9)
    price = 0.5 * float(np.linalg.slogdet(information + np.eye(len(sums)))[1])
    prior = np.diag(np.linalg.inv(information / inflation + np.eye(len(sums))))
    return Linear(
        log_bf,
        -0.5 * degrees * float(np.log1p(-fall)) - price,
        fitted * scale,
        np.asarray(prior < thresholds.USED.learned),
        np.asarray(columns @ (fitted * scale)),
    )


@dataclass(frozen=True)
class Gain:
    """Another gain of the drives of some joints: all their measured torque by one factor.

    Attributes:
        joints: their indices.
        log_bf: nats, tempered.  evidence: nats, to compare causes.
        logarithm: of the gain's ratio to what it was.
    """

    joints: tuple[int, ...]
    log_bf: float
    evidence: float
    logarithm: float

    def suited(self, whitened: Whitened, later: Flags) -> float:
        """Return the log evidence of few samples with the noise that suits the cause.

        With the noise that another cause needs, or none, each looks worse than it is.
        """
        samples = whitened.problem.samples
        at = np.ix_(np.flatnonzero(later), np.array(self.joints))
        tau = samples.tau.copy()
        tau[at] *= np.exp(-self.logarithm)
        problem = whitened.problem.of(replace(samples, tau=tau))
        scaled = replace(whitened, problem=problem)
        refitted = refit(scaled, whitened.basis, problem.nuisance)
        begins = whitened.x.time[later].min()
        count = int((refitted.samples.x.time >= begins).sum()) * len(self.joints)
        return exact(refitted).system.log_evidence - self.logarithm * count


def _scaled(whitened: Whitened, later: Flags, joints: Sequence[int]) -> Floats:
    """Return (n,) the torques of some joints measured later, whitened."""
    tau = whitened.problem.samples.tau
    b = np.zeros_like(whitened.residual)
    for joint in joints:
        b += whitened.whitened((tau[:, joint] * later)[:, None], joint)[:, 0]
    return whitened.project(b[:, None])[:, 0]


def gain_half(whitened: Whitened, later: Flags, joints: Sequence[int]) -> float:
    """Return half the width of the 90 % interval of a gain's logarithm, where it is undone."""
    b = _scaled(whitened, later, joints)[:, None]
    return float(reach(whitened, b, whitened.residual, 1.0 / (b.T @ b))[0])


def gain(whitened: Whitened, later: Flags, joints: Sequence[int]) -> Gain:
    """Return the gain of some joints' drives fitted and judged.

    With s the factor that undoes it, the residual is r + (s - 1) b, where b are the torques
    measured later. The evidence counts that scaled torques have another density.

    Args:
        later: (S,) the samples at which it may be another one.
    """
    b = _scaled(whitened, later, joints)
    r, degrees = whitened.residual, whitened.system.degrees
    count = float(later.sum() * len(joints))
    rr, rb, bb = float(r @ r), float(r @ b), float(b @ b)
    x = np.linspace(-np.log(5.0), np.log(5.0), GRID)
    u = np.expm1(x)
    likelihood = count * x - 0.5 * degrees * np.log1p((2.0 * u * rb + u**2 * bb) / rr)
    k = int(np.clip(np.argmax(likelihood), 1, GRID - 2))
    step = float(x[1] - x[0])
    before, here, after = likelihood[k - 1 : k + 2].tolist()
    curvature = max(-(before - 2.0 * here + after) / step**2, 1e-300)
    found = float(x[k]) + 0.5 * (after - before) / step / curvature
    left = r + np.expm1(found) * b
    pull = -np.exp(found) * degrees / float(left @ left) * b * left
    density = np.zeros((len(later), whitened.joints))
    density[:, list(joints)] = later[:, None]
    scores = np.add.reduceat(pull + density.ravel(), whitened.starts)
    inflation = float(variance_inflation_of(scores, curvature))

    def judged(f: float) -> float:
        posterior = curvature / f + LOG_GAIN**-2
        fit = here / f - 0.5 * (found / LOG_GAIN) ** 2
        return fit - 0.5 * float(np.log(posterior * LOG_GAIN**2))

    return Gain(tuple(joints), judged(inflation), judged(1.0), -found)


def gains(whitened: Whitened, later: Flags, joints: Iterable[int]) -> list[Gain]:
    """Return the gain of each of some joints' drives, and that of all of them together."""
    some = list(joints)
    together = [some] if len(some) > 1 and len(some) == whitened.joints else []
    return [gain(whitened, later, one) for one in ([[n] for n in some] + together)]


@dataclass(frozen=True)
class Friction:
    """Other sizes of all effects that the model has on a joint.

    Attributes:
        joint: its index.  columns: (S, P) N·m of each.
        log_bf: nats, tempered.  evidence: nats, to compare causes.
    """

    joint: int
    columns: Floats
    log_bf: float
    evidence: float

    @classmethod
    def of(cls, whitened: Whitened, later: Flags, joint: int) -> "Friction":
        """Return the friction of a joint fitted and judged."""
        mine = [term for term in whitened.basis.terms if term.joint == joint]
        columns = [one.columns(whitened.x) * later[:, None] for one in mine]
        own = np.column_stack([*columns, np.zeros((len(later), 0))])
        every = np.zeros((len(later), whitened.joints, own.shape[1]))
        every[:, joint] = own
        fitted = linear(whitened, every)
        return cls(joint, own, fitted.log_bf, fitted.evidence)

    def suited(self, whitened: Whitened) -> float:
        """Return the log evidence with the noise that suits it, see `Gain.suited`."""
        scaled = self.columns * expected(self.columns, float(whitened.spread[self.joint]))
        nuisance = (Nuisance(self.joint, scaled), *whitened.problem.nuisance)
        system = exact(refit(whitened, whitened.basis, nuisance)).system
        own = slice(whitened.basis.size, whitened.basis.size + scaled.shape[1])
        # The restricted evidence has a flat prior: multiply by the prior's density.
        covariance = np.eye(scaled.shape[1]) + system.amplitude * system.covariance[own, own]
        found = system.coefficients[own]
        squares = float(found @ np.linalg.solve(covariance, found))
        spread = float(np.linalg.slogdet(2.0 * np.pi * covariance)[1])
        return system.log_evidence - 0.5 * (squares + spread)
