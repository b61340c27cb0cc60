"""The two rods, what the search assumes of them, and motions designed for them."""

from functools import cache

import numpy as np
import two_rods
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.excite import (
    Assumed,
    Between,
    Design,
    Effort,
    For,
    Limits,
    Reference,
    Suspect,
    design,
    excite,
    limits_of,
    seen_pose,
)
from lagrangian_ff.diagnosis.excite.keeping import Keeper
from lagrangian_ff.diagnosis.excite.starts import template
from lagrangian_ff.identification import Model, Settings, identify

Floats = NDArray[np.float64]

SECONDS, SIZE = 8.0, 0.05
STUCK = Suspect("stribeck", "elbow", {"v_s": 0.15})
TINY = Effort(rows=160, starts=1, first=4, rounds=((4, 30.0), (4, 1e3)))


@cache
def rods() -> Model:
    """Return a model of the two rods, with plain friction."""
    few = Settings(train=1.0, samples=100, evaluations=12)
    return identify(two_rods.motion(1, 30.0), few).model


@cache
def assumed() -> Assumed:
    """Return what the search assumes of them."""
    return Assumed.of(rods())


@cache
def designed() -> Design:
    """Return the motion that shows whether the elbow sticks."""
    small = Effort(rows=300, starts=1, first=10, rounds=((15, 30.0), (10, 1e3), (5, 1e4)))
    return design(rods(), For(STUCK), seconds=SECONDS, assumed=assumed(), effort=small)


@cache
def usual() -> Reference:
    """Return the template for the same, over about as soon."""
    limits = limits_of(rods())
    start = seen_pose(rods(), "elbow", limits)
    return template("slow sweep", rods().joints, limits, "elbow", start, SECONDS)


def swing() -> Reference:
    """Return a motion of both joints."""
    return excite("exciting", rods().joints, limits_of(rods()), duration=SECONDS)


def keeper(limits: Limits | None = None) -> Keeper:
    return Keeper(rods(), limits or limits_of(rods()), np.zeros(2))


QUESTIONS = [
    For(STUCK),
    For(Suspect("ripple", "elbow")),
    Between(Suspect("stribeck", "elbow"), Suspect("power_law", "elbow")),
]
