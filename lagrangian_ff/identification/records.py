"""The findings of an identification, as JSON holds them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.identification.certainty.calibration import reach
from lagrangian_ff.identification.mechanics.dynamics import Dynamics, least, no_lagrangian
from lagrangian_ff.identification.predicting import TorqueModel
from lagrangian_ff.identification.problem import Problem
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.solving.posterior import Posterior
from lagrangian_ff.identification.solving.robust import outliers_of
from lagrangian_ff.kernels import CoupledKernel
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.sampling import usual_step

STATES = 100
"""States of the training motion at which the mass matrix is checked."""
NARROW = 0.6
"""Share of a joint's range below which the joint is named as the place."""


@dataclass(frozen=True)
class Score:
    """Errors of predicted torque, per joint.

    Attributes:
        joints: names.
        rmse: (N,) N·m, root mean square.
        nmse: (N,) mean squared error over the variance of the measured torque: 0 is perfect, 1 is
            no better than the mean; NaN where the torque did not vary.
    """

    joints: tuple[str, ...]
    rmse: Floats
    nmse: Floats

    @classmethod
    def of(cls, joints: tuple[str, ...], measured: Floats, predicted: Floats) -> "Score":
        """Return the errors of predicted torques (M, N) in N·m."""
        squared = np.mean((measured - predicted) ** 2, axis=0)
        variance = np.var(measured, axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            nmse = np.where(variance > 0.0, squared / variance, np.nan)
        return cls(joints, np.sqrt(squared), nmse)

    def record(self) -> dict[str, object]:
        """Return for JSON the errors by joint, their root mean square, and the mean nmse."""
        return {
            "joints": {
                name: {"rmse": float(r), "nmse": float(n)}
                for name, r, n in zip(self.joints, self.rmse, self.nmse, strict=True)
            },
            "rmse": float(np.sqrt(np.mean(self.rmse**2))),
            "nmse": float(np.nanmean(self.nmse)) if np.isfinite(self.nmse).any() else float("nan"),
        }


def hyperparameter_record(problem: Problem) -> dict[str, object]:
    """Return by name a number common to all joints, or a list with one for each."""

    def plain(values: Floats) -> object:
        return float(values[0]) if np.all(values == values[0]) else [float(v) for v in values]

    kernel = {name: plain(v) for name, v in problem.kernel.hyperparameters.items()}
    gamma = problem.noise / len(problem.samples)
    if isinstance(problem.kernel, CoupledKernel):
        gamma = gamma[:1]
    shapes: dict[str, object] = {}
    for term in problem.basis.terms:
        for name in term.shape:
            alike = [t for t in problem.basis.terms if t.effect.name == term.effect.name]
            values = np.array([t.shape[name] for t in alike])
            shapes[f"{term.effect.name}.{name}"] = plain(values)
    return {**kernel, "gamma": plain(gamma), **shapes}


def effect_records(
    posterior: Posterior, value: Floats, joints: tuple[str, ...], block: Ints
) -> list[dict[str, object]]:
    """Return every effect on every joint, its parameters with 90 % intervals.

    Args:
        posterior: to make intervals from.
        value: (B,) the parameters found, which a constraint or another loss may have moved.
        joints: names.
        block: (M,) the block of time that each training sample lies in.
    """
    away = reach(posterior, block)
    low, high = value - away, value + away
    found: list[dict[str, object]] = []
    for term, place in posterior.problem.basis.slices():
        parameters = {
            parameter.name: {
                "value": float(value[i]),
                "low": float(low[i]),
                "high": float(high[i]),
                "unit": parameter.unit,
            }
            for parameter, i in zip(
                term.effect.parameters, range(place.start, place.stop), strict=True
            )
        }
        found.append(
            {
                "effect": term.effect.name,
                "joint": joints[term.joint],
                "formula": term.effect.formula,
                "parameters": parameters,
                "shape": dict(term.shape),
                "shape_words": term.effect.shape_words(term.shape, joints),
            }
        )
    return found


def mass_record(model: TorqueModel) -> dict[str, object]:
    """Return where on the training motion the mass matrix is not positive definite, for JSON.

    Returns:
        `words` for people, and `defined`, whether the joints share a Lagrangian. Where they do,
        also `states`, the number checked; `share`, of those where it is not positive definite;
        `least`, the least eigenvalue in kg·m²; `joint`, the main one in its direction;
        `where`, for each joint the range in rad of the states where it is not positive.
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
    ranges = zip(motion.q[bad].T, model.joints, strict=True) if bad.any() else ()
    where = {name: [float(q.min()), float(q.max())] for q, name in ranges}
    found = f"least eigenvalue {values[worst]:.3g} kg·m², mostly {joint}"
    if bad.any():
        percent = 100.0 * float(bad.mean())
        share = f"{percent:.0f} %" if percent >= 1.0 else "less than 1 %"
        words = (
            f"the mass matrix is not positive definite on {share} of the training motion "
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


def _place(where: dict[str, list[float]], q: Floats, joints: Sequence[str]) -> str:
    """Return the joints whose range is narrower there, the two narrowest at most, in words."""
    width = np.maximum(np.ptp(q, axis=0), 1e-9)
    parts = [(high - low) / width[n] for n, (low, high) in enumerate(where.values())]
    narrow = [n for n in np.argsort(parts)[:2] if parts[n] < NARROW]
    if not narrow:
        return "all over it"
    ranges = ((joints[n], *where[joints[n]]) for n in narrow)
    return "where " + " and ".join(
        f"{name} is near {low:.2f} rad"
        if high - low < 0.01
        else f"{name} is from {low:.2f} to {high:.2f} rad"
        for name, low, high in ranges
    )


def outlier_record(
    weight: Floats, threshold: Floats, motion: Motion, residual: Floats, missed: Floats
) -> dict[str, object]:
    """Return the share and the longest stretch of outliers for JSON, with a sentence for people.

    Args:
        weight: (M, N) IRLS weight of each torque.
        threshold: (N,) N·m, beyond which the loss is linear.
        motion: M samples that the kernel is built on.
        residual: (M, N) N·m, torque minus the prediction of a fit without it.
        missed: (H, N) N·m, the same on motion held out.

    Returns:
        `share` of all torques that count less than half; `joints`, with `share`, `threshold` in
        N·m and `held_out_median` of the error in N·m of each; `longest`, the longest stretch of
        them, with its joint, begin and length in s; `rmse_of_others` in N·m on blocks left out, of
        the other torques; `words`.
    """
    off = outliers_of(weight)
    longest = _longest(off, motion)
    shares = dict(zip(motion.joints, map(float, off.mean(axis=0)), strict=True))
    median = map(float, np.median(np.abs(missed), axis=0))
    others = float(np.sqrt(np.mean(residual[~off] ** 2))) if not off.all() else None
    return {
        "share": float(off.mean()),
        "joints": {
            name: {"share": share, "threshold": float(limit), "held_out_median": half}
            for (name, share), limit, half in zip(shares.items(), threshold, median, strict=True)
        },
        "longest": longest,
        "rmse_of_others": others,
        "words": _words(float(off.mean()), shares, longest, others),
    }


def _longest(off: Flags, motion: Motion) -> dict[str, object] | None:
    """Return the longest time in which a joint's torque is an outlier without interruption."""
    if not off.any():
        return None
    step = usual_step(motion.time, motion.segment)
    found: list[tuple[float, float, str]] = []
    for joint, name in enumerate(motion.joints):
        here = np.where(off[:, joint], motion.segment, -1)
        edges = np.flatnonzero(np.diff(here, prepend=-2, append=-2))
        for first, last in zip(edges[:-1], edges[1:] - 1, strict=True):
            if off[first, joint]:
                length = float(motion.time[last] - motion.time[first]) + step
                found.append((length, float(motion.time[first]), name))
    length, begin, name = max(found, key=lambda one: one[0])
    return {"joint": name, "begin": begin, "seconds": length}


def _words(
    share: float,
    shares: dict[str, float],
    longest: dict[str, object] | None,
    others: float | None,
) -> str:
    if longest is None or others is None:
        return "Huber's loss: every torque counts at least half"
    most = sorted((name for name in shares if shares[name] > 0.0), key=lambda n: -shares[n])
    named = ", ".join(f"{name} {shares[name]:.1%}" for name in most)
    return (
        f"Huber's loss: {share:.1%} of the torques count less than half ({named}); the longest "
        f"stretch is {longest['seconds']:.2f} s of {longest['joint']}, from "
        f"{longest['begin']:.2f} s on. On blocks left out, the others are missed by "
        f"{others:.3g} N·m"
    )
