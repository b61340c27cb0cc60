"""Grounds of the two rods and of other motions, and their dense matrices, for small tests."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
import two_rods
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.ground import Ground, lay, tune, tuning
from lagrangian_ff.effects import EFFECTS, Inputs
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.kernels import States
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]
Stages = tuple[tuple[int, int], ...]

SHORT: Stages = ((60, 10), (120, 3), (240, 1))


@contextmanager
def quickly(rows: int, stages: Stages | None = None) -> Iterator[None]:
    """Lay grounds on few torques, and climb their evidence in few steps where `stages` say so."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tuning, "ROWS", rows)
        if stages is not None:
            patch.setattr(tuning, "STAGES", stages)
        yield


def friction(width: float = two_rods.WIDTH) -> Basis:
    """Viscous and Coulomb friction, its step `width` rad/s, and an offset of both joints."""
    return Basis(
        tuple(
            Term(EFFECTS[name], joint, {"v0": width} if name == "coulomb" else {})
            for joint in range(2)
            for name in ("viscous", "coulomb", "offset")
        )
    )


def inputs(motion: Motion) -> Inputs:
    """What effects are evaluated on."""
    return Inputs.of(States.of(motion.q, motion.qd, motion.qdd), motion.time, motion.segment)


def ground_of(motion: Motion, basis: Basis | None = None) -> Ground:
    """The tuned ground of a motion; without a basis it has plain friction."""
    return tune(motion, inputs(motion), friction() if basis is None else basis)


def begun(ground: Ground, count: int) -> Ground:
    """Its first samples alone, without a basis."""
    index, block = ground.index[:count], ground.block[:count]
    return lay(ground.motion, index, block, ground.inputs, ground.prior, Basis(()))


def dense(ground: Ground) -> tuple[Floats, Floats]:
    """(n, n) Gram matrix with its noise, and (n,) torques, normalised, of a few samples."""
    lower = ground.prior.gram(ground.seen)
    noise = np.tile(ground.prior.noise, len(ground.seen.q))
    gram = np.tril(lower) + np.tril(lower, -1).T + np.diag(noise)
    return gram, (ground.seen.mean(ground.motion.tau) / ground.prior.unit).ravel()
