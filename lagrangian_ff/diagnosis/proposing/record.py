"""The JSON of proposed formulas, as the command line writes it."""

from dataclasses import asdict
from typing import Any

from lagrangian_ff.diagnosis.proposing.propose import Proposal, Proposals


def proposals_record(found: Proposals) -> dict[str, Any]:
    """Return the formulas with what speaks for each; `effects` is as a file of effects holds it."""
    return {
        "joint": found.joint,
        "tried": found.tried,
        "null": {"threshold": found.threshold},
        "curve_gain": found.curve,
        "curve_error": found.curve_error,
        "confirmed_on": found.confirmed_on,
        "proposals": [_record(one) for one in found.proposals],
        **found.record(),
    }


def _record(one: Proposal) -> dict[str, Any]:
    finding = one.finding
    before, after = finding.errors
    return {
        **one.record(),
        "verdict": finding.said,
        "reason": finding.doubt.words if finding.doubt else "",
        "evidence_gain": finding.log_bayes_factor,
        "p_value": finding.p_value,
        "parameters": {name: asdict(value) for name, value in finding.parameters.items()},
        "shape": dict(finding.shape),
        "ambiguous_with": list(finding.rivals),
        "error_before": before,
        "error_after": after,
    }
