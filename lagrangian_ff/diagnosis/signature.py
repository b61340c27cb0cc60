"""What the search saw: the rest of the torque over the coordinate in which an effect shows."""

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.diagnose import Diagnosis, Finding
from lagrangian_ff.diagnosis.search.unnamed import since_reversal
from lagrangian_ff.effects import Inputs

Floats = NDArray[np.float64]

BINS, FINE_BINS = 24, 72
ALONG = ("velocity", "direction")
"""Coordinates that tell the direction of motion themselves."""
UNITS = {
    "velocity": "rad/s", "position": "rad", "acceleration": "rad/s²", "load": "N·m", "time": "s",
    "direction": "sign(qd)", "since_reversal": "s", "order": "rad", "predicted_torque": "N·m",
}  # fmt: skip


def signature(diagnosis: Diagnosis, finding: Finding) -> dict[str, object]:
    """The partial residual of a finding: what is left, with the effect's own torque put back.

    Returns:
        For JSON: the coordinate, its unit, and by bin its mean, the mean residual in N·m with a
        90 % band, and the mean torque of the effect.
    """
    ground = diagnosis.search.ground
    candidate = finding.step.score.candidate
    x = ground.seen
    effect = candidate.columns(x) @ finding.parameters
    left = ground.system.weights.reshape(len(ground.index), ground.joints)[:, candidate.joint]
    left = left * ground.prior.noise[candidate.joint] * ground.prior.unit[candidate.joint]
    if finding.effect.kind == "friction" and finding.effect.coordinate not in ALONG:
        # Both directions would cancel: shown along the motion.
        direction = np.sign(x.qd[:, candidate.joint])
        effect, left = effect * direction, left * direction
    coordinate = finding.effect.coordinate
    if finding.effect.kind == "transmission" and finding.effect.remembers:
        # No state shows what depends on the past: it is held against its own prediction.
        coordinate = "predicted_torque"
    at = effect if coordinate == "predicted_torque" else _coordinate(coordinate, x, candidate.joint)
    bins = FINE_BINS if coordinate == "order" else BINS
    edges = np.unique(np.quantile(at, np.linspace(0.0, 1.0, bins + 1)))
    place = np.clip(np.searchsorted(edges, at, side="right") - 1, 0, max(len(edges) - 2, 0))
    numbers = np.unique(place)
    rows = [place == number for number in numbers]
    mean = np.array([np.mean((effect + left)[row]) for row in rows])
    reach = np.array([1.645 * np.std(left[row]) / np.sqrt(max(1, row.sum())) for row in rows])
    return {
        "coordinate": "position" if coordinate == "order" else coordinate.replace("_", " "),
        "unit": UNITS.get(coordinate, ""),
        "x": [float(np.mean(at[row])) for row in rows],
        "residual": mean.tolist(),
        "low": (mean - reach).tolist(),
        "high": (mean + reach).tolist(),
        "effect": [float(np.mean(effect[row])) for row in rows],
    }  # fmt: skip


def _coordinate(name: str, x: Inputs, joint: int) -> Floats:
    if name in ("position", "order"):
        return x.q[:, joint]
    if name == "acceleration":
        return x.qdd[:, joint]
    if name == "load":
        return x.load[:, joint]
    if name == "time":
        return x.time
    if name == "direction":
        return np.asarray(np.sign(x.qd[:, joint]))
    if name == "since_reversal":
        return since_reversal(x, joint)
    return x.qd[:, joint]
