"""The catalogue of physical effects, and the groups that have a name of their own."""

from lagrangian_ff.effects.base import (
    KINDS,
    MOTIONS,
    Effect,
    Parameter,
    Shape,
    checked_columns,
    checked_energies,
)
from lagrangian_ff.effects.catalogue import EFFECTS, GROUPS
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.effects.user import load_effects, load_installed

__all__ = [
    "EFFECTS",
    "GROUPS",
    "KINDS",
    "MOTIONS",
    "Effect",
    "Inputs",
    "Parameter",
    "Shape",
    "checked_columns",
    "checked_energies",
    "load_effects",
    "load_installed",
]
