"""Checks of the effort: its unit and its sign."""

import numpy as np

from lagrangian_ff.diagnosis.preflight.base import SIGN, Case, Check, scaling, turned_round
from lagrangian_ff.diagnosis.preflight.scaled import Scaled, scaled

SERIOUS = 1.5
"""Factor between measured and expected torque, either way, that no missing effect explains."""
NOTED = 1.2
_LOAD = "a load that changed: this motion does not show enough of friction to tell the two apart"
_ALIKE = 1.15  # how far the joints' factors may be apart to be one

UNITS = {
    1000.0: "N·mm or mN·m",
    100.0: "N·cm",
    10.197: "kgf·cm",
    8.851: "lbf·in",
    0.7376: "lbf·ft",
    0.10197: "kgf·m",
    0.001: "kN·m",
}
"""By their number in one N·m."""
_SAME_UNIT = 1.06


def check_unit(case: Case) -> list[Check]:
    """Report the ratio of measured and predicted torque, where the two follow each other."""
    clear = np.flatnonzero(case.clear & (case.slope > 0.0))
    if not clear.size:
        finding = (
            "on no joint does the measured torque follow the model closely enough to tell whether "
            "it is in N·m"
        )
        return [Check("effort unit", None, finding)]
    factor = case.slope[clear]
    common = float(np.exp(np.median(np.log(factor))))
    alike = clear.size >= 2 and bool(np.all(np.abs(np.log(factor / common)) < np.log(_ALIKE)))
    off = [int(n) for n in clear if _off(case.slope[n]) >= NOTED]
    parts = {n: scaled(case, n) for n in off}
    unit = next((name for number, name in UNITS.items() if _off(common / number) < _SAME_UNIT), "")
    one_factor = alike and _off(common) >= SERIOUS
    if one_factor and (unit or not any(one.objection for one in parts.values())):
        return [_all(case, common, unit, sum(one.known for one in parts.values()) > len(parts))]
    found = [_one(case, n, parts[n]) for n in off]
    low, high = float(factor.min()), float(factor.max())
    finding = f"the measured torque is {low:.2f} to {high:.2f} times the model's: the same unit"
    return found or [Check("effort unit", None, finding, values={"lowest": low, "highest": high})]


def check_sign(case: Case) -> list[Check]:
    """Report joints whose measured torque falls where the model's rises."""
    turned = np.flatnonzero(case.clear & (case.slope < 0.0)).tolist()
    if len(turned) == len(case.joints):
        remedy = turned_round(case.motion, case.joints)
        finding = "the effort of every joint has the sign opposite to the model's"
        advice = (
            f"Give {remedy.option}, or correct the driver: effort is the torque that the "
            "motor puts on the joint"
        )
        values = {"correlation": float(case.correlation.max())}
        return [Check(SIGN, None, finding, True, advice, values, remedy=remedy)]
    found = []
    for n in turned:
        name, correlation = case.joints[n], case.correlation[n]
        finding = (
            f"the effort of {name} has the sign opposite to the model's (correlation "
            f"{correlation:.2f})"
        )
        remedy = turned_round(case.motion, [name])
        advice = f"Give {remedy.option}, or correct the driver"
        values = {"correlation": correlation, "factor": case.slope[n]}
        found.append(Check(SIGN, name, finding, True, advice, values, remedy=remedy))
    return found


def _off(factor: float) -> float:
    return float(max(factor, 1.0 / factor))


def _all(case: Case, factor: float, unit: str, sure: bool) -> Check:
    """Return the finding that all torques have one factor.

    Args:
        unit: that it makes of N·m; empty if there is none.
        sure: whether several parts of a torque were seen to have it.
    """
    guess = f"it seems to be in {unit}" if unit else "it is in another unit, or a motor current"
    finding = f"the effort of every joint is {factor:.4g} of what the model expects: {guess}"
    words = f"Multiply the effort by {1.0 / factor:.4g}"
    remedy = scaling(case.motion, dict.fromkeys(case.joints, 1.0 / factor), words)
    advice = f"Record effort in N·m, or give {remedy.option}"
    if not sure and not unit:
        finding += f"; or {_LOAD}"
    serious, values = sure or bool(unit), {"factor": factor}
    return Check("effort unit", None, finding, serious, advice, values, remedy=remedy)


def _one(case: Case, n: int, parts: Scaled) -> Check:
    """Return the finding that the torque of a joint is not the model's; a unit scales all parts."""
    name, factor = case.joints[n], float(case.slope[n])
    finding = f"the effort of {name} is {factor:.2f} of what the model expects"
    values = {"factor": factor, "correlation": case.correlation[n]}
    for part, one in parts.factors.items():
        values |= {part: one.value, f"{part}, low": one.low, f"{part}, high": one.high}
    if parts.objection:
        finding += f", and {parts.objection}"
        advice = "Ask what changed since the model was identified: diagnose --since"
        return Check("effort unit", name, finding, False, advice, values)
    if _off(factor) < SERIOUS:
        advice = "A wrong torque constant, a changed load or a missing effect may do this"
        return Check("effort unit", name, finding, False, advice, values)
    finding += ": other unit, gear ratio or torque constant?"
    words = f"Multiply the effort of {name} by {1.0 / factor:.4g}"
    remedy = scaling(case.motion, {name: 1.0 / factor}, words)
    advice = f"Check the driver's scale; {remedy.option} undoes it"
    if parts.known < 2:
        finding += f" Or {_LOAD}"
    return Check("effort unit", name, finding, parts.known > 1, advice, values, remedy=remedy)
