"""Whitened motions of the two rods and of others, and their dense matrices, for small tests."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import two_rods
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.thresholds import Effort, using
from lagrangian_ff.diagnosis.whitening import Whitened, fit, whiten
from lagrangian_ff.effects import EFFECTS, Inputs
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.kernels import States
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]
Stages = tuple[tuple[int, int], ...]

SHORT: Stages = ((60, 10), (120, 3), (240, 1))


@contextmanager
def quickly(rows: int, stages: Stages | None = None) -> Iterator[None]:
    """Whiten few torques, and maximise their evidence in few steps where `stages` say so."""
    effort = Effort(rows) if stages is None else Effort(rows, stages)
    with using(effort=effort):
        yield


def few_torques(rows: int, stages: Stages | None = None) -> Any:
    """Return a fixture with which all tests of a module run `quickly`."""

    @pytest.fixture(autouse=True, scope="module")
    def few() -> Iterator[None]:
        with quickly(rows, stages):
            yield

    return few


def friction(width: float = two_rods.WIDTH) -> Basis:
    """Return viscous and Coulomb friction, its step `width` rad/s, and an offset of both joints."""
    return Basis(
        tuple(
            Term(EFFECTS[name], joint, {"v0": width} if name == "coulomb" else {})
            for joint in range(2)
            for name in ("viscous", "coulomb", "offset")
        )
    )


def inputs(motion: Motion) -> Inputs:
    """Return the inputs that effects are evaluated on."""
    return Inputs.of(States.of(motion.q, motion.qd, motion.qdd), motion.time, motion.segment)


def whitened_of(motion: Motion, basis: Basis | None = None) -> Whitened:
    """Return a motion whitened and fitted; without a basis it has plain friction."""
    return fit(motion, inputs(motion), friction() if basis is None else basis)


@cache
def clean_rods() -> Whitened:
    """Return the whitened of a motion in which nothing is hidden."""
    with quickly(1000):
        return whitened_of(two_rods.motion(1, 30.0))


def begun(whitened: Whitened, count: int) -> Whitened:
    """Return its first samples alone, without a basis."""
    problem = replace(whitened.problem.having(basis=Basis(())), nuisance=())
    parts = whitened.motion, whitened.index[:count], whitened.seconds, whitened.inputs
    return whiten(*parts, problem)


def dense(whitened: Whitened) -> tuple[Floats, Floats]:
    """Return the Gram matrix (n, n) with noise, and the torques (n,), normalised."""
    problem = whitened.problem
    lower = problem.gram(tuple(range(whitened.joints)))
    noise = np.tile(problem.variances, len(problem.samples))
    gram = np.tril(lower) + np.tril(lower, -1).T + np.diag(noise)
    return gram, (problem.samples.tau / problem.unit).ravel()
