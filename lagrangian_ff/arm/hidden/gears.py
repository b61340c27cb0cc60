"""The torque that a gear between rotor and link adds to what the reported motion needs."""

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arm.hidden.base import Installed, Site, unexplained_by

Floats = NDArray[np.float64]

WINDOW = 0.03  # s, over which the servo's noise is averaged out of a twist


def elasticity_torque(installed: Installed, site: Site) -> Floats:
    """As for eccentricity; along a stiff run, the motor is taken as load / stiffness ahead."""
    (gear,) = installed.gears
    return _torque(site, gear.joint, site.along.load[:, gear.joint] / gear.stiffness)


def backlash_torque(installed: Installed, site: Site) -> Floats:
    """As for elasticity; along a stiff run, half the play ahead to the load's side."""
    (gear,) = installed.gears
    load = site.along.load[:, gear.joint]
    side = np.tanh(load / (0.05 * np.sqrt(np.mean(load**2))))
    return _torque(site, gear.joint, 0.5 * gear.play * side)


def _torque(site: Site, joint: int, estimate: Floats) -> Floats:
    run = site.along
    ahead = run.ahead[:, joint] if np.any(run.ahead[:, joint]) else estimate
    ahead = _smooth(ahead, round(WINDOW / run.dt))
    rate = np.gradient(ahead, run.dt)
    q, qd, qdd = run.q.copy(), run.qd.copy(), run.qdd.copy()
    q[:, joint] += ahead
    qd[:, joint] += rate
    qdd[:, joint] += np.gradient(rate, run.dt)
    return unexplained_by(site, q, qd, qdd)


def _smooth(values: Floats, width: int) -> Floats:
    """Twice averaged over a window, the ends held."""
    for _ in range(2):
        padded = np.pad(values, (width // 2, width - 1 - width // 2), mode="edge")
        values = np.convolve(padded, np.full(width, 1.0 / width), mode="valid")
    return values
