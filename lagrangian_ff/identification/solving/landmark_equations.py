"""Solving the semi-parametric model on landmarks, from as many samples as there are.

Samples of a motion do not err independently: what the kernel cannot express lasts for many of
them. With a noise that was chosen on few, many would be believed too much, and more data could make
the error worse. The noise is therefore multiplied by the factor with which groups of blocks, left
out in turn, are predicted best. It costs no further look at the samples.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.choice import Choice, Scaling
from lagrangian_ff.identification.solving.equations import rows_to_learn
from lagrangian_ff.identification.solving.fit import Fit
from lagrangian_ff.identification.solving.landmarks import Landmarks
from lagrangian_ff.identification.solving.low_rank import LowRank
from lagrangian_ff.identification.solving.rows import Rows
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.dense import together
from lagrangian_ff.progress import Progress, part, silent

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FACTORS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)
"""What the noise chosen on few samples may be multiplied with."""


@dataclass(frozen=True)
class LandmarkEquations:
    """What `Equations` are with the kernel built on landmarks; see `low_rank`.

    Attributes:
        choice: the hyperparameters.  scaling: of the torques.  basis: the effects' terms.
        landmarks: (C, N) states.
        samples: M, how many are learned from.
        groups: samples that are left out together; every sample in one of them.
        parts: which joints are solved together, their basis, landmarks, and what they learn from.
    """

    choice: Choice
    scaling: Scaling
    basis: Basis
    landmarks: States
    samples: int
    groups: tuple[Ints, ...]
    parts: tuple[tuple[tuple[int, ...], Basis, Landmarks, Rows], ...]

    @classmethod
    def of(
        cls,
        basis: Basis,
        choice: Choice,
        x: Inputs,
        tau: Floats,
        scaling: Scaling,
        landmarks: States,
        groups: Sequence[Ints],
    ) -> "LandmarkEquations":
        """The equations of x (M, N) and tau (M, N) N·m; see the attributes.

        Raises:
            NotPositiveDefiniteError: the Gram matrix of the landmarks is not finite.
        """
        parts = []
        for joints in together(choice.kernel, x.joints):
            own, rows = rows_to_learn(basis, choice, x, tau, scaling, joints)
            parts.append((joints, own, Landmarks.of(choice.kernel, landmarks, joints), rows))
        return cls(choice, scaling, basis, landmarks, len(x), tuple(groups), tuple(parts))

    def solve(
        self, trust: Floats | None = None, *, last: bool = True, progress: Progress = silent
    ) -> Fit[LowRank]:
        """Sum over the samples, and solve.

        Args:
            trust: (M, N) of each torque; None trusts all.
            last: for `Equations`; here nothing is overwritten.
            progress: told the share done.

        Returns:
            The fit; its choice has the noise that was found best.

        Raises:
            NotPositiveDefiniteError: the noise is too small for the arithmetic.
        """
        trust = np.ones((self.samples, self.landmarks.joints)) if trust is None else trust
        systems, noise = [], self.choice.noise.copy()
        for number, (joints, own, landmarks, rows) in enumerate(self.parts):
            share = part(progress, number / len(self.parts), (number + 1) / len(self.parts))
            known = rows.trusted(trust[:, list(joints)])
            system = LowRank.of(landmarks, known, self.groups, share)
            if len(self.groups) > 1:
                system = _tempered(system)
            noise[list(joints)] *= system.factor
            systems.append((joints, own, system))
        choice = replace(self.choice, noise=noise)
        parts = tuple(systems)
        return Fit(choice, self.scaling, self.basis, self.landmarks, self.samples, parts, trust)


def _tempered(system: LowRank) -> LowRank:
    """With the noise that leaves the smallest error on groups left out."""
    best, least = system, np.inf
    for factor in FACTORS:
        tried = replace(system, factor=factor)
        error = tried.error_left_out
        if error >= least:
            break
        best, least = tried, error
    return best
