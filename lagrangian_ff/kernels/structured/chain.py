"""Kernels of serial arms: joints in their order, base first."""

from lagrangian_ff.kernels.structured.base import Structured
from lagrangian_ff.kernels.structured.factors import BELL, COSINE


class Chain(Structured):
    """The rigid-body dynamics of every serial arm, and little else; see `serial`.

    Cosine factors: inertia and gravity are the trigonometric polynomials that rigid bodies have.
    """

    name = "chain"
    meaning = "one Lagrangian of a serial arm: quadratic in velocity, gravity apart"
    form = COSINE
    serial = True


class ChainRbf(Structured):
    """As `Chain`, with inertia and gravity any smooth functions of the angles they depend on."""

    name = "chain_rbf"
    meaning = "as chain, with rbf factors: gears and links need not be rigid bodies"
    form = BELL
    serial = True
