"""A smooth motion that visits much of the workspace, for tests of any room."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def sines(
    rng: np.random.Generator, t: Floats, joints: int, frequencies: tuple[float, float]
) -> tuple[Floats, Floats, Floats]:
    """Six random sines a joint.

    Args:
        rng: of frequencies, phases and amplitudes.
        t: (M,) s.
        joints: N.
        frequencies: rad/s, the lowest and the highest.

    Returns:
        q, qd and qdd, (M, N) each, in rad, rad/s and rad/s².
    """
    q, qd, qdd = np.zeros((3, len(t), joints))
    for _ in range(6):
        omega, phase = rng.uniform(*frequencies, joints), rng.uniform(0, 2 * np.pi, joints)
        size = rng.uniform(0.3, 0.8, joints) / omega**0.7
        angle = omega * t[:, None] + phase
        q += size * np.sin(angle)
        qd += size * omega * np.cos(angle)
        qdd -= size * omega**2 * np.sin(angle)
    return q, qd, qdd
