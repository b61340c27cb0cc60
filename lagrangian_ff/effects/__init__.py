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
from lagrangian_ff.effects.catalogue import EFFECTS, GROUPS, effect_record, look_alikes, meaning_of
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.effects.user import load_effects, load_installed

__all__ = [
    "EFFECTS", "GROUPS", "KINDS", "MOTIONS", "PARTS", "Effect", "Inputs", "Parameter", "Shape",
    "checked_columns", "checked_energies", "effect_record", "load_effects", "load_installed",
    "look_alikes", "meaning_of",
]  # fmt: skip
