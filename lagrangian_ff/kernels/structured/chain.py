"""Kernels of serial arms: joints in their order, base first."""

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels.base import Learned
from lagrangian_ff.kernels.states import States
from lagrangian_ff.kernels.structured.base import BELL, COSINE, Structured
from lagrangian_ff.kernels.structured.collapse import MOST_JOINTS, collapsed

Floats = NDArray[np.float64]


class Chain(Structured):
    """The rigid-body dynamics of every serial arm, and little else; see `serial.c`.

    Cosine factors: inertia and gravity are the trigonometric polynomials that rigid bodies have.
    """

    name = "chain"
    meaning = "one Lagrangian of a serial arm: quadratic in velocity, gravity apart"
    form = COSINE
    serial = True

    def learned(self, u: States, a: Floats) -> Learned:
        """See `Kernel.learned`: a polynomial, unless a joint slides or there are too many."""
        if u.joints > MOST_JOINTS or self.prismatic.any():
            return super().learned(u, a)
        return collapsed(self, u, a)


class ChainRbf(Structured):
    """As `Chain`, with inertia and gravity any smooth functions of the angles they depend on."""

    name = "chain_rbf"
    meaning = "as chain, with rbf factors: gears and links need not be rigid bodies"
    form = BELL
    free = True
    serial = True
