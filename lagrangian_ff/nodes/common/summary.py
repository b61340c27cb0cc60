"""The record of an identification, in words and for the diagnostics."""

from collections.abc import Mapping
from typing import Any


def held_out(record: Mapping[str, Any]) -> dict[str, str]:
    """Held-out error by joint: RMSE in N·m and the share of the torque's variance missed."""
    return {
        f"held-out error {joint}": f"{error['rmse']:.4g} N·m, nMSE {error['nmse']:.4g}"
        for joint, error in record.get("joints", {}).items()
    }


def lines(record: Mapping[str, Any]) -> list[str]:
    """What to log at the end."""
    return [
        f"identified {record['model']} from {record['samples']} samples in "
        f"{record['seconds']:.1f} s; RMSE {record['rmse']:.4g} N·m, nMSE {record['nmse']:.4g} on "
        "motion it has not seen",
        *(f"  {what}: {error}" for what, error in held_out(record).items()),
    ]
