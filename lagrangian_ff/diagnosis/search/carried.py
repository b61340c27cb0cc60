"""Friction on unseen motion, taken from the searched motion.

A finding is tested together with the model's own friction. Where that is fitted to ten seconds of
unseen motion alone, a little more viscous and Coulomb friction explains a drag as well. The
searched motion is longer and knows the friction better. So friction is taken from there, as it was
fitted with the finding and as it would be without. Friction may differ between the motions, by
temperature or age; how much is read from the unseen motion.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.diagnosis.search.fitted import Fitted
from lagrangian_ff.diagnosis.whitening import Whitened
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.choosing.shapes import orthonormal

DRIFTS = (0.0, 0.01, 0.03, 0.1, 0.3, 1.0, 10.0)
"""By how much the torque of each friction term may differ between the motions, as a share of all
friction of the joint. With the last, the searched motion says nothing."""
ROUNDS = 3
SHOWS = 1e-5
"""Share of a column that is left beside others, above which it can be told from them."""


@dataclass(frozen=True)
class Carried:
    """The parameters of the model's friction on unseen motion, as the searched motion leaves them.

    Attributes:
        design: (S N, B) their whitened columns on the unseen motion.
        exchanged: (B, S' N) times the whitened torque of an effect on the searched motion, how they
            change where that effect is left out.
        residual: (S N,) whitened torque of the unseen motion, less what they are expected to be.
        explained: (S N, K) columns V for which I − V Vᵀ whitens what the parameters leave open.
        drift: (N,) by how much friction differs between the motions, as `DRIFTS`.
    """

    design: Floats
    exchanged: Floats
    residual: Floats
    explained: Floats
    drift: Floats

    @classmethod
    def of(cls, searched: Whitened, own: Sequence[Term], unseen: Whitened) -> "Carried | None":
        """Return the friction of a model on unseen motion; None if the other shows none of it.

        Args:
            searched: with all findings in its basis, after those of the model.
            own: the effects of the model, the first of both motions' bases.
            unseen: with the findings' torques subtracted.
        """
        terms, found = searched.basis.terms[: len(own)], searched.basis.terms[len(own) :]
        fitted = Fitted.of(searched).holding(found)
        there = searched.system.white_design / searched.amplitude
        here = unseen.system.white_design / unseen.amplitude
        rubs = _friction(unseen.basis)
        beside = [*np.setdiff1d(np.arange(unseen.basis.size), rubs), *fitted.beside(terms)]
        mine, known = _outside(orthonormal(there[:, beside]), there[:, rubs])
        # What the searched motion does not show is fitted to the unseen one.
        rubs, mine = rubs[known], mine[:, known]
        if not len(rubs):
            return None
        joint, values = unseen.basis.joints[rubs], fitted.values[rubs]
        free = orthonormal(np.delete(here, rubs, axis=1))
        seen, _ = _outside(free, here[:, rubs])
        left = unseen.system.white_target / unseen.amplitude - here[:, rubs] @ values
        left -= free @ (free.T @ left)
        factor = cho_factor(mine.T @ mine)
        covariance = np.asarray(cho_solve(factor, np.eye(len(rubs))))
        scale = _scale(seen, values, joint)
        drift = _drift(seen, left, covariance, scale, joint, searched.joints)
        spread = np.linalg.cholesky(covariance + np.diag((drift[joint] * scale) ** 2))
        u, s, _ = np.linalg.svd(seen @ spread, full_matrices=False)
        explained = np.hstack([free, u * np.sqrt(1.0 - 1.0 / np.sqrt(1.0 + s**2))])
        exchanged = np.asarray(cho_solve(factor, mine.T))
        residual = left - explained @ (explained.T @ left)
        return cls(seen, exchanged, residual, explained, drift)

    def white(self, unseen: Floats, searched: Floats) -> Floats:
        """Return (S N,) by how much a torque changes the prediction, whitened.

        The model's own parameters change with it: they have been fitted beside it.

        Args:
            unseen: (S N,) the torque on the unseen motion, whitened.
            searched: (S' N,) the same on the searched motion.
        """
        z = unseen - self.design @ (self.exchanged @ searched)
        return np.asarray(z - self.explained @ (self.explained.T @ z))


def _friction(basis: Basis) -> Ints:
    """Return the places (B,) of the parameters of friction.

    An offset is of the sensor as much as of the arm, and may be another in another recording.
    """
    rubs = [t.effect.part == "friction" for t in basis.terms for _ in t.effect.parameters]
    return np.flatnonzero(np.array(rubs, dtype=np.bool_))


def _outside(span: Floats, columns: Floats) -> tuple[Floats, Flags]:
    """Return columns (n, B) less their part in a span, and (B,) where more than rounding is left.

    Args:
        span: (n, R) orthonormal.
    """
    left = columns - span @ (span.T @ columns)
    shows = np.linalg.norm(left, axis=0) > SHOWS * np.linalg.norm(columns, axis=0)
    return np.where(shows, left, 0.0), shows


def _scale(seen: Floats, values: Floats, joint: Ints) -> Floats:
    """Return by how much each parameter (B,) may change, for a drift of one."""
    whole = np.array([np.linalg.norm(seen[:, joint == n] @ values[joint == n]) for n in joint])
    norms = np.linalg.norm(seen, axis=0)
    return np.divide(whole, norms, out=np.zeros_like(norms), where=norms > 0.0)


def _drift(
    seen: Floats, left: Floats, covariance: Floats, scale: Floats, joint: Ints, joints: int
) -> Floats:
    """Return the most likely drift (N,) of each joint, from what the findings leave."""
    information, moment = seen.T @ seen, seen.T @ left

    def log_likelihood(drift: Floats) -> float:
        spread = covariance + np.diag((drift[joint] * scale) ** 2)
        whole = np.eye(len(spread)) + information @ spread
        gained = moment @ spread @ np.linalg.solve(whole, moment)
        return float(0.5 * gained - 0.5 * np.linalg.slogdet(whole)[1])

    drift = np.zeros(joints)
    for _ in range(ROUNDS):
        for n in np.unique(joint):
            tried = [np.where(np.arange(len(drift)) == n, one, drift) for one in DRIFTS]
            drift = max(tried, key=log_likelihood)
    return drift
