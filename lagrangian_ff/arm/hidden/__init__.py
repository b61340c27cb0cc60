"""Effects hidden in the physics of the simulated arm, to be found from its recordings.

State equations, masses, springs, gears and sensors; no code in common with the catalogue of
effects that is to find them.
"""

from lagrangian_ff.arm.hidden.base import HiddenEffect, Installed, Reference, Site
from lagrangian_ff.arm.hidden.catalogue import HIDDEN
from lagrangian_ff.arm.hidden.sizing import size, sized

__all__ = ["HIDDEN", "HiddenEffect", "Installed", "Reference", "Site", "size", "sized"]
