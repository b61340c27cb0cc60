"""The fit of drive gains: efforts that are gains times a torque linear in free parameters.

On joint j, with columns X of the parameters θ and a known torque k, and with what is free on the
joint alone projected out,

    e_j = a_j (X_j θ + k_j) + noise_j.

Given a, θ follows by weighted least squares. The likelihood of a, with θ and the noise of each
joint at their best, is climbed by damped steps. Only Gram matrices of the columns are needed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ModelError

OWN = 6
"""Columns that are free on each joint, behind the effort: rotor, offset, two of friction, twice."""
UNEXPLAINED = 0.5
"""Share of an effort's variance beside friction; with more left, its gain means nothing."""
ROUNDS, TRIALS, CLOSE = 60, 8, 1e-8
RANK, TINY = 1e-10, 1e-15
"""Share of the largest eigenvalue below which bodies' parameters cannot be told apart."""


@dataclass(frozen=True)
class Load:
    """What is known of the load's ten parameters, and what is free.

    Attributes:
        body: that carries it.  known: (10,) parameters.
        free: numbers of the parameters that are added to these.
        columns: number of the arm's own.
    """

    body: int
    known: Floats
    free: tuple[int, ...]
    columns: int

    @classmethod
    def of(cls, body: int, columns: int, mass: float, centre: Sequence[float] | None) -> "Load":
        """Return the load of a mass, kg, on a body; its centre is in m, None if unknown."""
        known = np.zeros(10)
        known[0] = mass
        free = tuple(range(1 if centre is None else 4, 10))
        if centre is not None:
            x, y, z = centre
            known[1:4] = mass * np.array([x, y, z])
            about = [y * y + z * z, -x * y, x * x + z * z, -x * z, -y * z, x * x + y * y]
            known[4:] = mass * np.array(about)
        return cls(body, known, free, columns)


@dataclass(frozen=True)
class Solution:
    """Gains, and what goes with them.

    Attributes:
        inverse: (N,) a = 1 / g, units of effort per N·m.
        noise: (N,) root mean square left, in units of effort.
        moment: (3,) kg·m of the load.  share: (N,) of the torque that the load adds.
        unexplained: (N,) share of the effort's variance beside friction that is left.
        residual: (N, C) what makes the residual of the columns of `_gram`.
        turn: see `Sums`.
    """

    inverse: Floats
    noise: Floats
    moment: Floats
    share: Floats
    unexplained: Floats
    residual: Floats
    turn: Floats

    def errors(self, grams: Floats) -> Floats:
        """Return (B, N) the root mean square residual of each block, in units of effort."""
        squares = np.einsum("nc,bncd,nd->bn", self.residual, grams, self.residual)
        count = grams[:, :, 1 - OWN, 1 - OWN]
        return np.asarray(np.sqrt(np.maximum(squares, 0.0) / count))

    def dissipated(self, gram: Floats) -> Floats:
        """Return (N,) the power of friction over that of the whole effort, with its sign."""
        friction, qd = (
            self.residual[:, 2 - OWN :],
            gram[:, 2 - OWN :, [2 - OWN, 4 - OWN]].sum(axis=2),
        )
        power = -np.einsum("nc,nc->n", friction, qd) * np.sign(self.inverse)
        speed = gram[:, 2 - OWN, 2 - OWN] + gram[:, 4 - OWN, 4 - OWN]
        effort = gram[:, -OWN - 1, -OWN - 1]
        return np.asarray(power / np.sqrt(np.maximum(speed * effort, 1e-300)))


@dataclass(frozen=True)
class Sums:
    """Moments of the columns of bodies x, of the load's known torque k and of the effort e.

    What is free on each joint is projected out.

    Attributes:
        xx: (N, P, P).  xk, xe: (N, P).  kk, ke, ee: (N,).
        count: (N,) samples.  fits: (N, OWN, C - OWN) the free columns' share in all others.
        turn: (C - OWN - 2, P) the physical parameters of each of the P that stand for them: those
            that the motion shows, each of as much torque.
        own: (N, C - OWN - 1, C - OWN - 1) of the physical parameters' columns and k.
    """

    xx: Floats
    xk: Floats
    xe: Floats
    kk: Floats
    ke: Floats
    ee: Floats
    count: Floats
    fits: Floats
    turn: Floats
    own: Floats

    @classmethod
    def of(cls, gram: Floats, turn: Floats | None = None) -> "Sums":
        """Return the sums of Gram matrices (N, C, C), for a turn that is known or their own."""
        inner = gram[:, :-OWN, :-OWN].copy()
        fits = []
        for joint, own in enumerate(gram):
            across = own[-OWN:, :-OWN]
            fits.append(np.linalg.lstsq(own[-OWN:, -OWN:], across, rcond=RANK)[0])
            inner[joint] -= across.T @ fits[joint]
        x, k, e = slice(0, -2), -2, -1
        if turn is None:
            whole = np.einsum("ncc->c", gram)[: inner.shape[1] - 2]
            turn = _turned(inner[:, x, x].sum(axis=0), whole)
        return cls(
            xx=turn.T @ inner[:, x, x] @ turn,
            xk=inner[:, x, k] @ turn,
            xe=inner[:, x, e] @ turn,
            kk=inner[:, k, k],
            ke=inner[:, k, e],
            ee=inner[:, e, e],
            count=gram[:, 1 - OWN, 1 - OWN],
            fits=np.array(fits),
            turn=turn,
            own=inner[:, :-1, :-1],
        )

    def torque(self, parameters: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the moments of the arm's torque with x (N, P), itself and e, (N,) each."""
        across = self.xx @ parameters + self.xk
        square = across @ parameters + self.xk @ parameters + self.kk
        return across, square, self.xe @ parameters + self.ke


def _turned(moments: Floats, whole: Floats) -> Floats:
    """Return (C, P) the directions of parameters that the motion shows, each of unit moment.

    Args:
        moments: (C, C) beside what is free on each joint.  whole: (C,) of the columns as they are.
    """
    own = np.diag(moments)
    shown = own > RANK * np.maximum(whole, 1e-300)
    scale = shown / np.sqrt(np.where(shown, own, 1.0))
    values, vectors = np.linalg.eigh(scale[:, None] * moments * scale)
    kept = values > RANK * values[-1]
    return np.asarray(scale[:, None] * vectors[:, kept] / np.sqrt(values[kept]))


def solved(gram: Floats, load: Load, near: "Solution | None") -> "Solution":
    """Return the gains of least weighted squares of effort.

    Args:
        gram: (N, C, C), see `_gram`.
        near: to begin with; None begins with the squares of torque, which are linear in g.
    """
    sums = Sums.of(gram, None if near is None else near.turn)
    if near is not None:
        return _solution(sums, load, _descended(sums, near.inverse, near.noise))
    best = _descended(sums, *_begin(sums))
    for joint in range(len(gram)):
        # A wrong sign at the beginning ends where nothing of the effort is explained.
        if best.noise[joint] ** 2 * sums.count[joint] > UNEXPLAINED * sums.ee[joint]:
            turned = best.a * np.where(np.arange(len(gram)) == joint, -1.0, 1.0)
            other = _descended(sums, turned, best.noise)
            best = min(best, other, key=lambda fit: fit.cost(sums))
    return _solution(sums, load, best)


@dataclass(frozen=True)
class Fit:
    """The parameters that fit best with some gains.

    Attributes:
        a: (N,) 1 / g.  parameters: (P,).  noise: (N,) units of effort.
        slope: (N,) of half the weighted squares, falling, by log a.
        curvature: (N, N) of them, the parameters following.
    """

    a: Floats
    parameters: Floats
    noise: Floats
    slope: Floats
    curvature: Floats

    @classmethod
    def of(cls, sums: Sums, a: Floats, noise: Floats) -> "Fit":
        """Return the fit for a, weighted by the noise of another."""
        weight = (a / noise) ** 2
        normal = np.einsum("n,npq->pq", weight, sums.xx)
        wanted = np.einsum("n,np->p", weight, sums.xe / a[:, None] - sums.xk)
        width = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
        scaled = width[:, None] * normal * width

        def weighed(right: Floats) -> Floats:
            found = np.linalg.lstsq(scaled, (width * right.T).T, rcond=TINY)[0]
            return np.asarray((width * found.T).T)

        parameters = weighed(wanted)
        across, square, effort = sums.torque(parameters)
        moved = (weight[:, None] * across).T
        curvature = np.diag(weight * square) - moved.T @ weighed(moved)
        slope = weight * (effort / a - square)
        squares = sums.ee - 2.0 * a * effort + a**2 * square
        left = np.sqrt(np.maximum(squares, 1e-12 * sums.ee) / sums.count)
        return cls(a, parameters, left, slope, curvature)

    def cost(self, sums: Sums) -> float:
        """Return minus the log likelihood, but for a constant."""
        return float(np.sum(sums.count * np.log(self.noise)))


def _descended(sums: Sums, a: Floats, noise: Floats) -> Fit:
    """Return the fit of largest likelihood near a (Levenberg 1944, Marquardt 1963)."""
    fit = Fit.of(sums, a, Fit.of(sums, a, noise).noise)
    damping = 1e-3
    for _ in range(ROUNDS):
        diagonal = np.diag(np.maximum(np.diag(fit.curvature), 1e-300))
        for _ in range(TRIALS):
            step = np.linalg.lstsq(fit.curvature + damping * diagonal, fit.slope, rcond=TINY)[0]
            step = np.clip(step, -1.0, 1.0)
            tried = Fit.of(sums, fit.a * np.exp(step), fit.noise)
            if tried.cost(sums) < fit.cost(sums):
                damping *= 0.1
                break
            damping *= 8.0
        else:
            return fit
        fit = tried
        if np.abs(step).max() < CLOSE:
            break
    return fit


def _solution(sums: Sums, load: Load, fit: Fit) -> "Solution":
    a, noise, physical = fit.a, fit.noise, sums.turn @ fit.parameters
    moment = load.known[1:4].copy()
    for place, number in enumerate(load.free):
        if number < 4:
            moment[number - 1] += physical[load.columns + place]
    every = np.append(physical, 1.0)
    of_load = np.where(np.arange(len(every)) < load.columns, 0.0, every)
    added, square = (np.einsum("p,npq,q->n", v, sums.own, v) for v in (of_load, every))
    share = np.sqrt(np.maximum(added, 0.0) / np.maximum(square, 1e-300))
    shown = np.column_stack([*(-np.outer(a, every)).T, np.ones(len(a))])
    free = -np.einsum("npq,nq->np", sums.fits, shown)
    return Solution(
        a,
        noise,
        moment,
        share,
        noise**2 * sums.count / sums.ee,
        np.hstack([shown, free]),
        sums.turn,
    )


def _begin(sums: Sums) -> tuple[Floats, Floats]:
    """Return a = 1 / g and a noise, from the least squares of torque.

    Raises:
        ModelError: an effort does not change.
    """
    joints, bodies = sums.xk.shape
    if not (sums.ee > 0.0).all():
        raise ModelError("the effort of a joint does not change: leave the joint out with --joints")
    normal = np.zeros((bodies + joints, bodies + joints))
    normal[:bodies, :bodies] = sums.xx.sum(axis=0)
    normal[:bodies, bodies:] = -sums.xe.T
    normal[bodies:, :bodies] = -sums.xe
    normal[bodies:, bodies:] = np.diag(sums.ee)
    right = np.concatenate([-sums.xk.sum(axis=0), sums.ke])
    width = 1.0 / np.sqrt(np.diag(normal))
    scaled = width[:, None] * normal * width
    found = width * np.linalg.lstsq(scaled, width * right, rcond=TINY)[0]
    gain = found[bodies:]
    least = 1e-9 * np.abs(gain).max(initial=0.0) or 1.0
    gain = np.where(np.abs(gain) > least, gain, least)
    return 1.0 / gain, 0.1 * np.sqrt(sums.ee / sums.count)
