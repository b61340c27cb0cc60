"""The derivatives of a structured kernel by its numbers, as sums of pieces of it.

K is linear in link, potential and rotor: the derivative by one of them is the kernel of this one
alone, of the joints up to it. K is affine in every joint's factor, taken with its square as it
changes at first (see `serial`): the derivative by ω is what a step along the factor's own makes of
K, less K. And K is a quadratic form Σ_jk Λ_j Λ_k B_jk of the inertias: with S_j what those of the
joints from j on make of it, and P_j those of the joints up to j,

    Λ_j ∂K/∂Λ_j = S_j − S_{j+1} + P_j − P_{j−1}.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from lagrangian_ff.kernels.structured.base import Structured

Floats = NDArray[np.float64]

KINETIC, POTENTIAL, ROTOR = 0, 1, 2
"""Of which part a piece is, and where its factors stand; a rotor's is qdd qdd' of one joint."""
STAYS = -1
"""Instead of the joint whose factor is moved, where none is."""


@dataclass(frozen=True)
class Piece:
    """One part of a kernel with changed numbers, of some of the joints.

    Attributes:
        kind: KINETIC, POTENTIAL or ROTOR.
        joints: the first, and the one after the last.
        inertia: (N,) Λ.
        share: (N,) κ or λ of the links.
        moved: the joint whose factor takes a step of 1 + ω along its derivative by ω, or STAYS.
    """

    kind: int
    joints: tuple[int, int]
    inertia: Floats
    share: Floats
    moved: int = STAYS


def slopes(kernel: "Structured") -> tuple[list[Piece], dict[str, Floats]]:
    """Pieces of a kernel, and by name (K, E) how these E add up to the derivatives by K numbers."""
    count, inertia, serial = len(kernel.inertia), kernel.inertia, kernel.serial
    every, joints, links = (0, count), range(count), range(count - len(kernel.link), count)
    # No mass of a serial arm depends on its first joint.
    turning = joints[1:] if serial else joints
    index, alone = np.arange(count), np.eye(count)
    link, potential = kernel.link @ alone[links], kernel.potential @ alone[links]
    pieces: list[Piece] = []

    def put(more: Iterable[Piece]) -> slice:
        before = len(pieces)
        pieces.extend(more)
        return slice(before, len(pieces))

    linked = put(Piece(KINETIC, (0, i + 1), inertia, alone[i]) for i in links)
    waved = put(Piece(KINETIC, every, inertia, link, n) for n in turning)
    up_to = put(Piece(KINETIC, every, inertia * (index <= j), link) for j in joints[:-1])
    # In a serial arm the joints from j on do not know of those before.
    from_on = put(
        Piece(KINETIC, (j if serial else 0, count), inertia * (index >= j), link)
        for j in joints[1:]
    )
    weighed = put(Piece(POTENTIAL, (0, i + 1), inertia, alone[i]) for i in links)
    swung = put(Piece(POTENTIAL, every, inertia, potential, n) for n in joints)
    turned = put(Piece(ROTOR, (n, n + 1), inertia, link) for n in joints)

    one = np.eye(len(pieces))
    kinetic, height = kernel.link @ one[linked], kernel.potential @ one[weighed]
    nothing = np.zeros(len(pieces))
    s = np.vstack([kinetic, one[from_on], nothing])
    p = np.vstack([nothing, one[up_to], kinetic])
    by_log_inertia = np.diff(p - s, axis=0) + _scaled(2.0 * kernel.rotor * inertia**2, one[turned])
    wave = np.zeros((count, len(pieces)))
    wave[turning] = one[waved] - kinetic
    return pieces, {
        "inertia": _scaled(1.0 / inertia, by_log_inertia),
        "link": one[linked],
        "potential": one[weighed],
        "wave": _scaled(1.0 / (1.0 + kernel.wave), wave),
        "swing": _scaled(1.0 / (1.0 + kernel.swing), one[swung] - height),
        "rotor": _scaled(inertia**2, one[turned]),
    }


def _scaled(by: Floats, rows: Floats) -> Floats:
    return np.asarray(by[:, None] * rows)
