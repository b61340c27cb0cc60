"""All effects by name, their groups, and what they are taken for."""

from collections.abc import Iterator
from dataclasses import asdict
from importlib import import_module
from types import ModuleType

from lagrangian_ff.effects.base import Effect
from lagrangian_ff.effects.curve import curve_named

_FILES = (
    "offset", "torque_gain", "saturation", "delay", "drift", "eccentricity", "viscous", "coulomb",
    "asymmetric_coulomb", "asymmetric_viscous", "asymmetric_step", "stribeck", "drag",
    "load_friction", "position_friction", "warm_up", "temperature_friction", "hysteresis",
    "ripple", "backlash", "elasticity", "coupled", "rotor_inertia", "spring", "counterbalance",
    "payload", "contact",
)  # fmt: skip
"""The file of each effect, beside this one. A new effect is its file and its name here."""


def effect_classes(module: ModuleType) -> Iterator[type[Effect]]:
    """Yield the effects that a module defines, in order; helpers whose name begins with _ are not.

    One that lacks `columns` is among them, so that its author hears of it.
    """
    for name, value in vars(module).items():
        own = isinstance(value, type) and value.__module__ == module.__name__
        if own and issubclass(value, Effect) and not name.startswith("_"):
            yield value


EFFECTS: dict[str, Effect] = {
    made.name: made()
    for file in _FILES
    for made in effect_classes(import_module(f"lagrangian_ff.effects.{file}"))
}
"""Every effect by its name."""

GROUPS: dict[str, tuple[str, ...]] = {"fri": ("viscous", "coulomb", "offset")}
"""Names that stand for several effects: `fri` is the friction basis (51) of the paper."""


def effect_of(name: str) -> Effect | None:
    """Return the effect, or the curve, of a name, for what it says of itself; None if none is."""
    return EFFECTS.get(name) or curve_named(name)


def look_alikes(effect: Effect) -> dict[str, str]:
    """Return the effects that one is taken for, by name, with how to tell the two apart.

    A pair is stated once, by one of the two.
    """
    others = {
        other.name: other.look_alikes[effect.name]
        for other in EFFECTS.values()
        if effect.name in other.look_alikes
    }
    return {**effect.look_alikes, **others}


def meaning_of(effect: Effect) -> str:
    """Return what an effect is, in words; else what its parameters are."""
    return effect.meaning or " and ".join(p.meaning for p in effect.parameters)


def effect_record(effect: Effect) -> dict[str, object]:
    """Return what an effect says about itself, as JSON holds it."""
    return {
        "name": effect.name, "kind": effect.kind, "formula": effect.formula,
        "meaning": meaning_of(effect),
        "source": effect.source,
        "parameters": [asdict(parameter) for parameter in effect.parameters],
        "shapes": [asdict(shape) for shape in effect.shapes], "coordinate": effect.coordinate,
        "shows_as": effect.shows_as, "look_alikes": look_alikes(effect), "motion": effect.motion,
        "next_motion": effect.next_motion, "remembers": effect.remembers,
        "uses": sorted(effect.uses), "caution": effect.caution,
    }  # fmt: skip
