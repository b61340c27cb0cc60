"""A model as forms and expressions: what every format that holds it whole is written from."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import Inputs
from lagrangian_ff.effects.base import BROUGHT
from lagrangian_ff.effects.curve import Curve
from lagrangian_ff.effects.formula import Formula
from lagrangian_ff.errors import ExportError
from lagrangian_ff.export.curves import PortableCurve
from lagrangian_ff.export.effects import mapped, unexportable
from lagrangian_ff.export.expressions import evaluated, names_in, parsed
from lagrangian_ff.export.rigid import Form, forms_of
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.identification.predicting import MotionRange

PARTNER = "qd_partner"
CHECKED = 50
"""States whose torques an export holds, so that whoever reads it can check what they compute."""


@dataclass(frozen=True)
class PortableTerm:
    """One effect on one joint: Σ coefficient × expression, in N·m.

    Attributes:
        effect: its name.
        joint: index of the joint whose state its expressions hold.
        on: (N,) the factor of its torque in each joint's.
        columns: an expression for each coefficient.
        coefficients: (P,) in the effect's units.
        values: numbers by name that stand in the expressions: its shapes, and v0.
        others: states of other joints by the name that they have in the expressions: q, qd, qdd or
            load, and the index of the joint.
        follows: whether `torque` is in it: the sum of load and of all effects that do not follow.
        constant: whether it is one torque at all times, which belongs to the load.
    """

    effect: str
    joint: int
    on: Floats
    columns: tuple[str, ...]
    coefficients: Floats
    values: Mapping[str, float]
    others: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    follows: bool = False
    constant: bool = False

    def torque(self, x: Inputs) -> Floats:
        """Return (M, N) N·m of states as the effects see them."""
        inputs = ("q", "qd", "qdd", "load", "torque")
        given = {name: getattr(x, name)[:, self.joint] for name in inputs} | dict(self.values)
        for name, (what, joint) in self.others.items():
            given[name] = getattr(x, what)[:, joint]
        total = np.zeros(len(x))
        for text, factor in zip(self.columns, self.coefficients, strict=True):
            total = total + factor * evaluated(parsed(text), given)
        return np.outer(total, self.on)


@dataclass(frozen=True)
class Portable:
    """A torque of N joints that is a function of the state.

    Attributes:
        joints: N names.
        source: name of the model, as `chain+fri`.
        unit: (N,) N·m that count as one in the forms.
        forms: their sum is the rigid-body torque.
        effects: their names, each once, in the model's order.
        terms: those that are expressions.  curves: those that are splines.
        range: the motion the model was identified on.
        settled: names of effects that are taken as settled, and what they are of.
    """

    joints: tuple[str, ...]
    source: str
    unit: Floats
    forms: tuple[Form, ...]
    effects: tuple[str, ...]
    terms: tuple[PortableTerm, ...]
    curves: tuple[PortableCurve, ...]
    range: MotionRange
    settled: Mapping[str, str] = field(default_factory=dict)


def portable(model: Model, *, settled: bool = False) -> Portable:
    """Return a model as numbers, forms and expressions.

    Args:
        model: to export.
        settled: leave what depends on the past, on time or on temperature as `Model.predict` has it
            without them; else such a model is refused.

    Raises:
        ExportError: the kernel or an effect has no such form; names it and says why.
    """
    joints = len(model.joints)
    speed = model.basis.sign_speed(joints)
    placed, curves = [], []
    for term, place in model.basis.slices():
        b = model.coefficients[place]
        if why := unexportable(term.effect):
            raise ExportError(f"the effect {term.effect.name} {why}")
        if isinstance(term.effect, Curve):
            width = float(speed[term.joint])
            curves.append(PortableCurve.of(term, term.effect, b, width))
        else:
            placed.append(_term(term, b, joints, speed))
    past = {term.effect: why for term, why in placed if why}
    if past and not settled:
        listed = "; ".join(f"{name}: {why}" for name, why in past.items())
        raise ExportError(
            f"not exported: {listed}. --settled leaves it as it is after a long steady motion, "
            "and says what that costs"
        )
    terms = tuple(term for term, _ in placed if set(term.columns) != {"0"})
    held = {term.effect for term in terms} | {curve.effect for curve in curves}
    names = dict.fromkeys(term.effect.name for term in model.basis.terms)
    return Portable(
        joints=model.joints,
        source=model.name,
        unit=model.unit,
        forms=forms_of(model.kernel, model.centres, model.weights),
        effects=tuple(name for name in names if name in held),
        terms=terms,
        curves=tuple(curves),
        range=model.range,
        settled=past,
    )


def _term(
    term: Term, coefficients: Floats, joints: int, speed: Sequence[float] | Floats
) -> tuple[PortableTerm, str]:
    """Return a term, and why it is settled; empty if it is not."""
    found = mapped(term.effect)
    if found is None:
        origin = BROUGHT.get(term.effect.name)
        raise ExportError(
            f"the effect {term.effect.name} is Python code"
            + (f" in {origin.name}" if origin else "")
            + ", which no other program runs: write it as a formula (a JSON file for "
            "--effects-file, see docs/workbench.md) and identify the model again"
        )
    used = set().union(*(names_in(parsed(text)) for text in found.columns))
    values = {"v0": float(speed[term.joint])} | {k: float(v) for k, v in term.shape.items()}
    made = PortableTerm(
        effect=term.effect.name,
        joint=term.joint,
        on=term.on(joints),
        columns=found.columns,
        coefficients=coefficients,
        values={name: value for name, value in values.items() if name in used},
        others=_others(term, used),
        follows="torque" in term.effect.uses,
        constant=term.effect.constant,
    )
    return made, found.refused


def _others(term: Term, used: Collection[str]) -> dict[str, tuple[str, int]]:
    """Return the states of other joints that expressions use, by their names there."""
    if PARTNER in used:
        return {PARTNER: ("qd", round(term.shape["partner"]))}
    if not isinstance(term.effect, Formula):
        return {}
    read = term.effect.inputs.items()
    return {name: (what, of) for name, (what, of) in read if of is not None and name in used}


def checked(model: Model) -> tuple[Floats, Floats, Floats, Floats]:
    """Return q, qd, qdd and torque, (CHECKED, N) each, spread over the model's recording."""
    data = model.data
    some = np.linspace(0, len(data) - 1, CHECKED).astype(np.int64)
    states = data.q[some], data.qd[some], data.qdd[some]
    return (*states, model.predict(*states))
