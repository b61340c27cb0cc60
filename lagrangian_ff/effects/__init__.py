"""The catalogue of physical effects, and the groups that have a name of their own."""

from lagrangian_ff.effects.base import Effect, Parameter, Shape, checked_columns
from lagrangian_ff.effects.coulomb import Coulomb
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.effects.offset import Offset
from lagrangian_ff.effects.viscous import Viscous

EFFECTS: dict[str, Effect] = {effect.name: effect for effect in (Viscous(), Coulomb(), Offset())}
"""Every effect by its name; a new one joins here and in its own file: the tests read this list."""

GROUPS: dict[str, tuple[str, ...]] = {"fri": ("viscous", "coulomb", "offset")}
"""Names that stand for several effects: `fri` is the friction basis (51) of the paper."""

__all__ = ["EFFECTS", "GROUPS", "Effect", "Inputs", "Parameter", "Shape", "checked_columns"]
