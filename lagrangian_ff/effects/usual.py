"""Which effects are usual for which gear: a weight that is shown beside the evidence.

A name never rests on it: no verdict reads it. It orders what the evidence cannot tell apart, and
which question an investigation asks first.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import log

from lagrangian_ff.errors import EffectError

USUAL, RARE = log(3.0), -log(3.0)
"""Nats by which an effect that is usual for a gear, or rare, is weighted against one that is not
named: odds of three to one, which twenty nats of evidence outweigh a million times."""


@dataclass(frozen=True)
class Gear:
    """A kind of gear or drive.

    Attributes:
        words: what it is called.
        usual: effects that are usual in it.
        rare: effects that it hardly ever has.
        sources: where that is measured.
    """

    words: str
    usual: tuple[str, ...]
    rare: tuple[str, ...]
    sources: tuple[str, ...]


GEARS: Mapping[str, Gear] = {
    "harmonic": Gear(
        "harmonic drive",
        ("stribeck", "hysteresis", "elasticity", "ripple", "position_friction", "load_friction",
         "power_law", "warm_up", "temperature_friction"),
        ("backlash",),
        ("Tuttle and Seering, IEEE Trans. Robotics and Automation 12(3), 1996: friction over "
         "position, compliance, resonance",
         "Seyfferth, Maghzal and Angeles, ICRA 1995: hysteresis and static friction over load",
         "Wolf and Iskandar, ICRA 2018: friction nonlinear in speed, and over temperature"),
    ),
    "cycloidal": Gear(
        "cycloidal or RV gear",
        ("stribeck", "load_friction", "load_viscous", "warm_up", "temperature_friction",
         "gear_mesh", "asymmetric_coulomb"),
        ("elasticity",),
        ("Bittencourt and Gunnarsson, ASME J. Dynamic Systems, Measurement and Control 134(5), "
         "2012: static friction over load and temperature of an industrial arm",),
    ),
    "planetary": Gear(
        "planetary or spur gear",
        ("backlash", "gear_mesh", "load_friction", "stribeck"),
        (),
        ("Hamon, Gautier and Garrec, IROS 2010: dry friction in proportion to the load",),
    ),
    "belt": Gear(
        "belt",
        ("elasticity", "ripple"),
        ("backlash",),
        ("Hace, Jezernik and Sabanovic, IEEE Trans. Industrial Electronics 54(6), 2007: a belt's "
         "elasticity",),
    ),
    "cable": Gear(
        "cable or tendon",
        ("hysteresis", "elasticity", "coupled", "position_friction", "load_friction"),
        ("gear_mesh", "backlash"),
        ("Kaneko, Yamashita and Tanie, ICAR 1991: friction and hysteresis of tendons",),
    ),
    "direct": Gear(
        "direct drive",
        ("ripple", "quadratic_drag"),
        ("stribeck", "hysteresis", "elasticity", "backlash", "gear_mesh", "load_friction"),
        ("Holtz and Springob, IEEE Trans. Industrial Electronics 43(2), 1996: torque ripple",),
    ),
}  # fmt: skip


def gear(name: str) -> Gear:
    """Return a gear by its name.

    Raises:
        EffectError: there is none.
    """
    if name not in GEARS:
        raise EffectError(f"there is no gear '{name}'; there are {', '.join(GEARS)}")
    return GEARS[name]


def weight(effect: str, name: str | None) -> float:
    """Return the nats by which a gear speaks for an effect; 0 without a gear."""
    if name is None:
        return 0.0
    known = gear(name)
    return USUAL if effect in known.usual else RARE if effect in known.rare else 0.0


def usual_words(effect: str, name: str | None) -> str:
    """Return what is known of an effect in a gear, in words; empty if nothing is."""
    nats = weight(effect, name)
    if name is None or nats == 0.0:
        return ""
    known = gear(name)
    how = "usual" if nats > 0.0 else "rare"
    return (
        f"{how} in a {known.words} ({nats:+.1f} nats, not part of the evidence; "
        f"{known.sources[0].partition(':')[0]})"
    )
