"""What the page shows of models, findings, curves and proposed formulas, as JSON."""

from typing import TYPE_CHECKING, Any

from lagrangian_ff.record_json import finite

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis.proposing import Proposals
    from lagrangian_ff.diagnosis.results import Diagnosis, Finding, Unexplained
    from lagrangian_ff.identification import Model
    from lagrangian_ff.identification.records import Estimate

Record = dict[str, Any]


def described(model: "Model") -> Record:
    """Return what the page shows of a model."""
    found = model.identified
    effects = [
        {
            "effect": one.effect,
            "joint": one.joint,
            "formula": one.formula,
            "parameters": {name: _estimate(value) for name, value in one.parameters.items()},
        }
        for one in found.effects
    ]
    return finite({
        "name": model.name,
        "joints": list(model.joints),
        "seconds": found.seconds,
        "effects": effects,
        "notes": list(found.notes),
    })  # fmt: skip


def finding_card(found: "Finding", diagnosis: "Diagnosis") -> Record:
    """Return what the page shows of a finding."""
    from lagrangian_ff.diagnosis.adding import for_history

    place = found.place(diagnosis.model.joints)
    return {**_card(found), "place": place, "why": for_history(found, diagnosis)}


def left_over(diagnosis: "Diagnosis") -> Record:
    """Return what no effect fits: torques over a coordinate, and joints with more than noise."""
    return {
        "unexplained": [_curve(one) for one in diagnosis.unexplained],
        "remainders": [
            {"joint": one.joint, "size": one.size, "share": one.share}
            for one in diagnosis.remainders
        ],
    }


def proposals_cards(found: "Proposals") -> Record:
    """Return a card for each proposed formula, and what they competed with."""
    return finite({
        "joint": found.joint,
        "tried": found.tried,
        "threshold": found.threshold,
        "curve_gain": found.curve,
        "curve_error": found.curve_error,
        "confirmed_on": found.confirmed_on,
        "formulas": [
            {
                **_card(one.finding),
                "place": found.joint,
                "meaning": one.words,
                "rivals": list(one.finding.rivals),
                "file": one.record(),
                "why": {
                    "why": f"proposed: {one.words}",
                    "verdict": one.finding.verdict.value,
                    "evidence_gain": one.finding.log_bayes_factor,
                    "p_value": one.finding.p_value,
                },
            }
            for one in found.proposals
        ],
    })  # fmt: skip


def _estimate(value: "Estimate") -> Record:
    return {"value": value.value, "low": value.low, "high": value.high, "unit": value.unit}


def _card(found: "Finding") -> Record:
    before, after = found.errors
    rest, blocks = found.partial_residual, found.consequence
    return {
        "effect": found.effect.name,
        "joint": found.joint,
        "meaning": found.effect.meaning,
        "formula": found.effect.formula,
        "verdict": found.verdict.value,
        "said": found.said,
        "doubt": found.doubt.words if found.doubt else "",
        "gain": found.log_bayes_factor,
        "p_value": found.p_value,
        "error_of": blocks.joint if blocks else found.joint,
        "before": before,
        "after": after,
        "told_apart_by": list(found.told_apart_by),
        "shape": dict(found.shape),
        "parameters": {name: _estimate(value) for name, value in found.parameters.items()},
        "curve": {
            "coordinate": rest.coordinate,
            "unit": rest.unit,
            **{name: getattr(rest, name).tolist()
               for name in ("x", "residual", "low", "high", "effect")},
        },
        "blocks": {
            "before": blocks.before.tolist(),
            "after": blocks.after.tolist(),
        } if blocks else None,
        "once": found.once,
    }  # fmt: skip


def _curve(rest: "Unexplained") -> Record:
    from lagrangian_ff.diagnosis.sentences import history_of_curve

    made, curve = rest.consequence, rest.curve
    return {
        "joint": rest.joint,
        "coordinate": rest.coordinate,
        "share": rest.share,
        "gain": rest.log_bayes_factor,
        "effect": curve and curve.name,
        "form": curve and {
            "over": [one.text() for one in curve.over], "friction": curve.friction
        },
        "before": made and made.whole_before,
        "after": made and made.whole_after,
        "worth": bool(made and made.worth),
        "blocks": made and {"before": made.before.tolist(), "after": made.after.tolist()},
        "curve": _drawn(rest),
        "why": history_of_curve(rest),
    }  # fmt: skip


def _drawn(rest: "Unexplained") -> Record | None:
    """Return the torque of a curve over its one coordinate; None where it has another form."""
    from lagrangian_ff.effects import Curve

    if rest.consequence is None or rest.curve is None or len(rest.curve.over) > 1:
        return None
    model = rest.consequence.model
    term, place = model.basis.slices()[-1]
    if not isinstance(term.effect, Curve):
        return None
    (at,), torque = term.effect.table(model.coefficients[place])
    (over,) = term.effect.over
    return {
        "coordinate": over.words,
        "unit": over.unit,
        "x": at.tolist(),
        "effect": torque.tolist(),
        "friction": term.effect.friction,
    }
