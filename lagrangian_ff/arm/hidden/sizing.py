"""How strong a hidden effect must be to have a given size."""

import numpy as np

from lagrangian_ff.arm.hidden.base import HiddenEffect, Installed, Site

TRIES = 12
CLOSE = 0.01  # of the size


def size(effect: HiddenEffect, installed: Installed, site: Site) -> float:
    """RMS of the effect's torque over RMS of all of that joint's motor torque, along the run."""
    run, j = site.along, site.joint
    return float(run.rms(effect.torque(installed, site))[j] / run.rms(run.motor)[j])


def sized(effect: HiddenEffect, site: Site, wanted: float) -> tuple[Installed, float]:
    """Install an effect so that it has the wanted size along the site's run.

    The size rises with the strength: a secant in logarithms, one step where it is proportional.

    Args:
        effect: what.  site: where.
        wanted: its size, such as 0.1.

    Returns:
        The effect, and the strength it has: `strongest`, if that is not enough for the size.
    """
    strength, power = min(effect.start, effect.strongest), 1.0
    before: tuple[float, float] | None = None
    for _ in range(TRIES):
        installed = effect.install(site, strength)
        found = max(size(effect, installed, site), 1e-9)
        if abs(found / wanted - 1.0) < CLOSE:
            break
        if strength == effect.strongest and found < wanted:
            break
        if before is not None and strength != before[0] and found != before[1]:
            slope = np.log(found / before[1]) / np.log(strength / before[0])
            power = float(np.clip(slope, 0.25, 4.0))
        before = strength, found
        step = float(np.clip((wanted / found) ** (1.0 / power), 0.1, 10.0))
        strength = min(strength * step, effect.strongest)
    return installed, strength
