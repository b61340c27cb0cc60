"""Effects hidden in the physics of the simulated arm, to be found from its recordings.

State equations, masses, springs, gears and sensors; no code in common with the catalogue of
effects that the diagnosis uses.
"""

from lagrangian_ff.arm.hidden.base import (
    HiddenEffect,
    Installed,
    Reference,
    Site,
    beyond_friction,
    size,
    sized,
)
from lagrangian_ff.arm.hidden.catalogue import HIDDEN

__all__ = [
    "HIDDEN",
    "HiddenEffect",
    "Installed",
    "Reference",
    "Site",
    "beyond_friction",
    "size",
    "sized",
]
