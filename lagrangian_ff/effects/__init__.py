"""The catalogue of physical effects, and the groups that have a name."""

from lagrangian_ff.effects.base import (
    KINDS,
    MOTIONS,
    PARTS,
    Effect,
    Parameter,
    Shape,
    checked_columns,
    checked_energies,
)
from lagrangian_ff.effects.catalogue import (
    EFFECTS,
    GROUPS,
    effect_of,
    effect_record,
    look_alikes,
    meaning_of,
)
from lagrangian_ff.effects.curve import Curve, Over, curve_over
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.effects.user import load_effects, load_installed

__all__ = [
    "EFFECTS", "GROUPS", "KINDS", "MOTIONS", "PARTS", "Curve", "Effect", "Inputs", "Over",
    "Parameter", "Shape", "checked_columns", "checked_energies", "curve_over", "effect_of",
    "effect_record", "load_effects", "load_installed", "look_alikes", "meaning_of",
]  # fmt: skip
