"""Fitting the semi-parametric model on landmarks, from as many samples as there are.

Samples of a motion do not err independently: what the kernel cannot express lasts for many of
them. With a noise that was chosen on few, many would be believed too much, and more data could make
the error worse. The noise is therefore multiplied by the factor with which groups of blocks, left
out in turn, are predicted best. It costs no further look at the samples.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.fit import Choice, Fit, Scaling, joints_together, rows_to_learn
from lagrangian_ff.identification.landmarks import Landmarks
from lagrangian_ff.identification.low_rank import LowRank
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, part, silent

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FACTORS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)
"""What the noise chosen on few samples may be multiplied with."""
MEMORY = 1.1e9  # bytes that the sums of all folds may take


def fit_landmarks(
    basis: Basis,
    choice: Choice,
    x: Inputs,
    tau: Floats,
    scaling: Scaling,
    landmarks: States,
    groups: Sequence[Ints],
    progress: Progress = silent,
) -> Fit[LowRank]:
    """Solve (44) with the kernel built on landmarks; see `low_rank`.

    Args:
        basis: the effects with their shapes.
        choice: hyperparameters.
        x: (M, N) training states.
        tau: (M, N) N·m.
        scaling: how torques are normalised.
        landmarks: (C, N) states.
        groups: samples that are left out together; every sample in one of them.
        progress: told the share done.

    Returns:
        The fit; its choice has the noise that was found best.

    Raises:
        ModelError: the sums would take too much memory.
    """
    together = joints_together(choice.kernel, x.joints)
    _require_room(len(landmarks), len(together[0]), len(groups))
    systems, noise = [], choice.noise.copy()
    for number, joints in enumerate(together):
        share = part(progress, number / len(together), (number + 1) / len(together))
        own, rows = rows_to_learn(basis, choice, x, tau, scaling, joints)
        system = LowRank.of(Landmarks.of(choice.kernel, landmarks, joints), rows, groups, share)
        if len(groups) > 1:
            system = _tempered(system)
        noise[list(joints)] *= system.factor
        systems.append((joints, own, system))
    return Fit(replace(choice, noise=noise), scaling, basis, landmarks, len(x), tuple(systems))


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


def _require_room(landmarks: int, joints: int, groups: int) -> None:
    needed = 8.0 * (groups + 2) * (landmarks * joints) ** 2
    if needed > MEMORY:
        most = int(np.sqrt(MEMORY / (8.0 * (groups + 2))) / joints)
        raise ModelError(
            f"{landmarks} landmarks of {joints} joints with {groups} folds would take "
            f"{needed / 1e9:.1f} GB, expected at most {MEMORY / 1e9:.1f} GB: use --landmarks "
            f"{most} or fewer"
        )
