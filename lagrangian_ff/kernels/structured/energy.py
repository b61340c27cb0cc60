"""Kernels of arms of any topology: energies, nothing known of the order of the joints."""

from lagrangian_ff.kernels.structured.base import BELL, COSINE, Structured


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
