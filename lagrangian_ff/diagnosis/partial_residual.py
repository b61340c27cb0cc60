"""The partial residual of an effect over the coordinate in which it shows."""

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.results import PartialResidual
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.diagnosis.whitening import Whitened
from lagrangian_ff.effects import Inputs

BINS, FINE_BINS = 24, 72
ALONG = ("velocity", "direction")
"""Coordinates that contain the direction of motion."""
UNITS = {
    "velocity": "rad/s", "position": "rad", "acceleration": "rad/s²", "load": "N·m", "time": "s",
    "direction": "sign(qd)", "since_reversal": "s", "order": "rad", "predicted_torque": "N·m",
}  # fmt: skip


def partial_residual(
    whitened: Whitened, candidate: Candidate, parameters: Floats
) -> PartialResidual:
    """Return the residual of a joint's torque plus that of an effect, by bins of a coordinate.

    Args:
        whitened: the motion, with the effect in its basis.
        candidate: the effect.  parameters: (P,) of the effect.
    """
    x, effect = whitened.x, candidate.effect
    torque = candidate.columns(x) @ parameters
    problem = whitened.problem
    left = whitened.system.weights.reshape(len(whitened.index), -1)[:, candidate.joint]
    left = left * problem.variances[candidate.joint] * problem.unit[candidate.joint]
    if effect.kind == "friction" and effect.coordinate not in ALONG:
        # Along the motion, since both directions would cancel.
        direction = np.sign(x.qd[:, candidate.joint])
        torque, left = torque * direction, left * direction
    coordinate = effect.coordinate
    if effect.kind == "transmission" and effect.remembers:
        # No state contains the past; the predicted torque does.
        coordinate = "predicted_torque"
    at = torque if coordinate == "predicted_torque" else _coordinate(coordinate, x, candidate.joint)
    bins = FINE_BINS if coordinate == "order" else BINS
    edges = np.unique(np.quantile(at, np.linspace(0.0, 1.0, bins + 1)))
    place = np.clip(np.searchsorted(edges, at, side="right") - 1, 0, max(len(edges) - 2, 0))
    rows = [place == number for number in np.unique(place)]
    mean = np.array([np.mean((torque + left)[row]) for row in rows])
    reach = np.array([1.645 * np.std(left[row]) / np.sqrt(max(1, row.sum())) for row in rows])
    return PartialResidual(
        coordinate="position" if coordinate == "order" else coordinate.replace("_", " "),
        unit=UNITS.get(coordinate, ""),
        x=np.array([np.mean(at[row]) for row in rows]),
        residual=mean,
        low=mean - reach,
        high=mean + reach,
        effect=np.array([np.mean(torque[row]) for row in rows]),
    )


def _coordinate(name: str, x: Inputs, joint: int) -> Floats:
    """Return a coordinate (S,) of a joint; velocity for any other name."""
    if name == "time":
        return x.time
    if name == "since_reversal":
        return x.since_reversal(joint)
    if name == "direction":
        return np.asarray(np.sign(x.qd[:, joint]))
    states = {"position": x.q, "order": x.q, "acceleration": x.qdd, "load": x.load}
    return states.get(name, x.qd)[:, joint]
