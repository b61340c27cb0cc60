"""The structured kernels: of serial arms, base first, and of arms of any topology."""

from lagrangian_ff.arrays import Floats
from lagrangian_ff.kernels.base import Learned
from lagrangian_ff.kernels.states import States
from lagrangian_ff.kernels.structured.base import BELL, COSINE, Structured
from lagrangian_ff.kernels.structured.polynomial import MOST_JOINTS, polynomial_of


class Chain(Structured):
    """The rigid-body dynamics of serial arms, see `serial.c`.

    Cosine factors: inertia and gravity are the trigonometric polynomials that rigid bodies have.
    """

    name = "chain"
    meaning = "one Lagrangian of a serial arm: quadratic in velocity, gravity apart"
    form = COSINE
    serial = True

    def learned(self, u: States, a: Floats) -> Learned:
        if u.joints > MOST_JOINTS or self.prismatic.any():
            return super().learned(u, a)
        return polynomial_of(self, u, a)


class ChainRbf(Structured):
    """As `Chain`, with inertia and gravity any smooth functions of the angles they depend on."""

    name = "chain_rbf"
    meaning = "as chain, with rbf factors: gears and links need not be rigid bodies"
    form = BELL
    free = True
    serial = True


class Energy(Structured):
    """Kinetic energy quadratic in velocity and a potential, both of all joints; see `product.c`.

    Cosine factors: inertia and gravity are trigonometric polynomials in every joint.
    """

    name = "energy"
    meaning = "one Lagrangian of any arm: quadratic in velocity, gravity apart"
    form = COSINE
    serial = False


class EnergyRbf(Structured):
    """As `Energy`, with inertia and gravity any smooth functions of the joints."""

    name = "energy_rbf"
    meaning = "as energy, with rbf factors: inertia and gravity any smooth functions"
    form = BELL
    free = True
    serial = False
