"""Whether a learned mass matrix is one: positive definite on the motion it was learned from."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification.mechanics.dynamics import Dynamics, no_lagrangian
from lagrangian_ff.identification.mechanics.forward import least
from lagrangian_ff.identification.model import Model
from lagrangian_ff.identification.samples import evenly

Floats = NDArray[np.float64]

STATES = 100
"""States of the training motion that are looked at."""
NARROW = 0.6
"""A joint's part of its range that says something of where."""


def mass_record(model: Model) -> dict[str, object]:
    """Where on the training motion the mass matrix is not positive definite, as JSON holds it.

    Returns:
        `words` for a person, and `defined`, whether the joints share a Lagrangian. Where they do,
        also `states`, how many were looked at; `share`, of those where it is not positive definite;
        `least`, the least eigenvalue of all in kg·m²; `joint`, the one its direction is mostly
        that of; `where`, for each joint the range in rad of the states where it is not positive.
    """
    reason = no_lagrangian(model)
    if reason:
        return {"defined": False, "words": reason}
    seen = np.flatnonzero(model.trained)
    motion = model.data.take(seen[evenly(len(seen), STATES)])
    values, directions = least(Dynamics(model).mass_matrix(motion.q, motion.qd))
    worst = int(np.argmin(values))
    joint = model.joints[int(np.argmax(np.abs(directions[worst])))]
    bad = values <= 0.0
    where = _ranges(motion.q[bad], model.joints)
    found = f"least eigenvalue {values[worst]:.3g} kg·m², mostly {joint}"
    if bad.any():
        words = (
            f"the mass matrix is not positive definite on {_percent(bad)} of the training motion "
            f"({found}), {_place(where, motion.q, model.joints)}: there is no forward dynamics "
            "there, and gravity and Coriolis torques are to be doubted; identify with --positive"
        )
    else:
        words = f"the mass matrix is positive definite all along the training motion ({found})"
    return {
        "defined": True,
        "states": len(motion),
        "share": float(bad.mean()),
        "least": float(values[worst]),
        "joint": joint,
        "where": where,
        "words": words,
    }


def _ranges(q: Floats, joints: Sequence[str]) -> dict[str, list[float]]:
    if not len(q):
        return {}
    return {name: [float(q[:, n].min()), float(q[:, n].max())] for n, name in enumerate(joints)}


def _place(where: dict[str, list[float]], q: Floats, joints: Sequence[str]) -> str:
    """The joints whose range is narrower there than on the whole, the two narrowest at most."""
    width = np.maximum(np.ptp(q, axis=0), 1e-9)
    parts = [(high - low) / width[n] for n, (low, high) in enumerate(where.values())]
    told = [n for n in np.argsort(parts)[:2] if parts[n] < NARROW]
    if not told:
        return "all over it"
    ranges = ((joints[n], *where[joints[n]]) for n in told)
    return "where " + " and ".join(
        f"{name} is near {low:.2f} rad"
        if high - low < 0.01
        else f"{name} is from {low:.2f} to {high:.2f} rad"
        for name, low, high in ranges
    )


def _percent(bad: NDArray[np.bool_]) -> str:
    share = 100.0 * float(bad.mean())
    return f"{share:.0f} %" if share >= 1.0 else "less than 1 %"
