"""Is the effort in N·m, and of the sign of the torque on the joint?"""

import numpy as np

from lagrangian_ff.diagnosis.preflight.base import Case, Check

SERIOUS = 1.5
"""Factor between measured and expected torque, either way, that no missing effect explains."""
NOTED = 1.2
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
    """The ratio of measured and predicted torque, where the two follow each other."""
    clear = np.flatnonzero(case.clear & (case.slope > 0.0))
    factor = case.slope
    if not clear.size:
        return [
            Check(
                "effort unit",
                None,
                "on no joint does the measured torque follow the model closely enough to tell "
                "whether it is in N·m",
            )
        ]
    common = float(np.exp(np.median(np.log(factor[clear]))))
    alike = clear.size >= 2 and bool(
        np.all(np.abs(np.log(factor[clear] / common)) < np.log(_ALIKE))
    )
    if alike and _off(common) >= SERIOUS:
        return [_all(case, common)]
    found = [_one(case, int(n)) for n in clear if _off(factor[n]) >= NOTED]
    return found or [
        Check(
            "effort unit",
            None,
            f"the measured torque is {factor[clear].min():.2f} to {factor[clear].max():.2f} times "
            "the model's: the same unit",
            values={"lowest": factor[clear].min(), "highest": factor[clear].max()},
        )
    ]


def check_sign(case: Case) -> list[Check]:
    """Whether measured torque falls where the model's rises."""
    turned = np.flatnonzero(case.clear & (case.slope < 0.0)).tolist()
    if len(turned) == len(case.joints):
        flips = " ".join(_scale(case, joint, -1.0) for joint in case.joints)
        return [
            Check(
                "effort sign",
                None,
                "the effort of every joint has the sign opposite to the model's",
                True,
                f"Give --effort-scale {flips}, or correct the driver: effort is the torque "
                "that the motor puts on the joint",
                {"correlation": float(case.correlation.max())},
            )
        ]
    return [
        Check(
            "effort sign",
            case.joints[n],
            f"the effort of {case.joints[n]} has the sign opposite to the model's (correlation "
            f"{case.correlation[n]:.2f})",
            True,
            f"Give --effort-scale {_scale(case, case.joints[n], -1.0)}, or correct the driver",
            {"correlation": case.correlation[n], "factor": case.slope[n]},
        )
        for n in turned
    ]


def _off(factor: float) -> float:
    return float(max(factor, 1.0 / factor))


def _scale(case: Case, joint: str, factor: float) -> str:
    """The option that undoes a factor, beside the scale that the recording was read with."""
    given = case.motion.conditioning.get("effort_scale")
    known = given.get(joint, 1.0) if isinstance(given, dict) else 1.0
    return f"{joint}={known / factor:.4g}"


def _all(case: Case, factor: float) -> Check:
    unit = next((name for number, name in UNITS.items() if _off(factor / number) < _SAME_UNIT), "")
    guess = f"it seems to be in {unit}" if unit else "it is in another unit, or a motor current"
    return Check(
        "effort unit",
        None,
        f"the effort of every joint is {factor:.4g} of what the model expects: {guess}",
        True,
        "Record effort in N·m, or give --effort-scale "
        + " ".join(_scale(case, name, factor) for name in case.joints),
        {"factor": factor},
    )


def _one(case: Case, n: int) -> Check:
    name, factor = case.joints[n], float(case.slope[n])
    serious = _off(factor) >= SERIOUS
    return Check(
        "effort unit",
        name,
        f"the effort of {name} is {factor:.2f} of what the model expects"
        + (": other unit, gear ratio or torque constant?" if serious else ""),
        serious,
        f"Check the driver's scale; --effort-scale {_scale(case, name, factor)} undoes it"
        if serious
        else "A wrong torque constant, a changed load or a missing effect may do this",
        {"factor": factor, "correlation": case.correlation[n]},
    )
