"""What each effect of the catalogue is elsewhere: an expression for each of its parameters.

A new effect is its line here. Names in an expression are, of the effect's own joint, q, qd, qdd,
`load` and `torque` (see `effects.Inputs`); `v0`, the width of the joint's smoothed sign; the shapes
of the effect; `qd_partner`, the speed of the joint that the shape `partner` counts; and in formulas
states of other joints, as q_2 of the second.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from lagrangian_ff.effects import Effect
from lagrangian_ff.effects.curve import Curve
from lagrangian_ff.effects.formula import SINCE, Formula
from lagrangian_ff.export.curves import READ
from lagrangian_ff.export.expressions import by_parameter, text_of

CLOCK = "it follows the time since a recording began, which a controller does not have"
WARMTH = "it follows a temperature, which is no part of a state"
PAST = "it depends on the past of the motion, and what is exported is a function of one state"


@dataclass(frozen=True)
class Mapped:
    """What an effect is elsewhere.

    Attributes:
        columns: an expression for each parameter; for a `refused` effect that of its settled
            state, as `Model.predict` has it without time.
        refused: why it is not exported as it is; empty if it is.
    """

    columns: tuple[str, ...]
    refused: str = ""


SIGN = "tanh(qd / v0)"
LOAD = "(load - Jr * qdd)"
SHAFT = "(qd + ratio * qd_partner)"

CATALOGUE: Mapping[str, Mapped] = {
    "offset": Mapped(("1",)),
    "torque_gain": Mapped(("load",)),
    "saturation": Mapped(("min(max(torque, -L), L) - torque",)),
    "delay": Mapped(("0",), PAST),
    "drift": Mapped(("0",), CLOCK),
    "eccentricity": Mapped(("load * cos(q)", "load * sin(q)")),
    "viscous": Mapped(("qd",)),
    "coulomb": Mapped((SIGN,)),
    "asymmetric_coulomb": Mapped((f"0.5 * ({SIGN} + 1)", f"0.5 * ({SIGN} - 1)")),
    "asymmetric_viscous": Mapped(("max(qd, 0)", "min(qd, 0)")),
    "asymmetric_step": Mapped(("tanh(qd / w) ^ 2",)),
    "stribeck": Mapped((f"{SIGN} * exp(-(qd / v_s) ^ 2)",)),
    "power_law": Mapped((f"{SIGN} * abs(qd) ^ p",)),
    "quadratic_drag": Mapped(("qd * abs(qd)",)),
    "load_friction": Mapped((f"abs{LOAD} * {SIGN}",)),
    "load_viscous": Mapped((f"abs{LOAD} * qd",)),
    "load_stribeck": Mapped((f"abs{LOAD} * {SIGN} * exp(-(qd / v_s) ^ 2)",)),
    "directional_friction": Mapped((f"(abs(torque - Jr * qdd) - abs{LOAD}) * {SIGN}",)),
    "position_friction": Mapped((f"{SIGN} * cos(q)", f"{SIGN} * sin(q)")),
    "warm_up": Mapped(("0", "0"), CLOCK),
    "temperature_friction": Mapped(("0", "0"), WARMTH),
    "hysteresis": Mapped(("0", "0", "0"), PAST),
    "ripple": Mapped(("cos(order * q)", "sin(order * q)")),
    "gear_mesh": Mapped((f"abs{LOAD} * cos(order * q)", f"abs{LOAD} * sin(order * q)")),
    "backlash": Mapped(("0", "0"), PAST),
    "elasticity": Mapped(("0", "0"), PAST),
    "coupled": Mapped((f"tanh({SHAFT} / v0)", SHAFT)),
    "rotor_inertia": Mapped(("qdd",)),
    "spring": Mapped(("q", "q ^ 3")),
    "counterbalance": Mapped(("sin(q - q0) / sqrt(1 + r ^ 2 - 2 * r * cos(q - q0))",)),
    "payload": Mapped(("load", "qdd", "cos(q)", "sin(q)"), CLOCK),
    "contact": Mapped(("0",), CLOCK),
}  # fmt: skip
"""Every effect of the catalogue, by name; the tests run over this list."""


def unexportable(effect: Effect) -> str:
    """Return why no format holds an effect, after its name; empty if one may."""
    past = isinstance(effect, Curve) and any(one.kind not in READ for one in effect.over)
    if past or (isinstance(effect, Formula) and SINCE in effect.inputs):
        return f"follows the time since the joint turned round: {PAST}"
    return ""


def mapped(effect: Effect) -> Mapped | None:
    """Return what an effect is elsewhere; None for one that a user wrote in Python."""
    if isinstance(effect, Formula):
        parameters = frozenset(one.name for one in effect.parameters)
        factors = by_parameter(effect.tree, parameters)
        return Mapped(tuple(text_of(factors[one.name]) for one in effect.parameters))
    return CATALOGUE.get(effect.name)
