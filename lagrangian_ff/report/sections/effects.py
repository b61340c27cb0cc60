"""The effects that a model found, as equations with their values."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from lagrangian_ff.effects import EFFECTS, Curve, effect_of
from lagrangian_ff.identification.certainty.calibration import LEVEL
from lagrangian_ff.numbers import typeset
from lagrangian_ff.report import html
from lagrangian_ff.report.page import Section

if TYPE_CHECKING:
    from lagrangian_ff.identification.records import FittedEffect

TITLE = "What the model found in the joints"
LEAD = (
    "The effects as equations, with the values identified and the intervals that should hold the "
    f"true ones {LEVEL:.0%} of the time."
)


def effects_section(
    found: "Sequence[FittedEffect]",
    truth: Mapping[tuple[str, str], Sequence[float]] | None = None,
    *,
    remark: str = "",
) -> Section:
    """Return a table for each effect, with a row for each joint.

    Args:
        found: every effect on every joint.
        truth: by effect and parameter, the true value of each joint in the order of `found`,
            where a simulator knows it.
        remark: small print under the tables.
    """
    names = dict.fromkeys(one.effect for one in found)
    if not names:
        return Section(TITLE, "", html.paragraph("The model has no effects besides its kernel."))
    parts = [_effect([one for one in found if one.effect == name], truth or {}) for name in names]
    return Section(TITLE, LEAD, "".join(parts) + (html.note(remark) if remark else ""))


def _effect(
    found: "Sequence[FittedEffect]", truth: Mapping[tuple[str, str], Sequence[float]]
) -> str:
    """Return heading, meaning and table of one effect on all its joints."""
    name, formula = found[0].effect, found[0].formula
    about = effect_of(name)
    meaning = f"{about.meaning}." if about else ""
    header, rows = ["joint"], [[one.joint] for one in found]
    rows_of = {} if isinstance(about, Curve) else found[0].parameters
    for parameter, first in rows_of.items():
        known = truth.get((name, parameter))
        header += [f"{parameter} [{first.unit}]", f"{LEVEL:.0%} interval"]
        header += ["true value"] if known is not None else []
        for n, one in enumerate(found):
            value = one.parameters[parameter]
            rows[n] += [typeset(value.value), f"{typeset(value.low)} … {typeset(value.high)}"]
            rows[n] += [typeset(float(known[n]))] if known is not None else []
    for shape in found[0].shape:
        header.append(f"{shape} [{_unit(name, shape)}]")
        for n, one in enumerate(found):
            rows[n].append(one.shape_words[shape])
    return (
        f'<h3>{html.escape(name)} <span class="formula">τ = {html.escape(formula)}</span></h3>'
        f"{html.paragraph(meaning[:1].upper() + meaning[1:]) if meaning else ''}"
        f"{html.table(header, rows, strong=1)}"
    )


def _unit(effect: str, shape: str) -> str:
    shapes = EFFECTS[effect].shapes if effect in EFFECTS else ()
    return next((one.unit for one in shapes if one.name == shape), "")
