"""The findings in a solved model: effects with intervals, its mass matrix, and outliers."""

from collections.abc import Mapping, Sequence

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.identification.certainty.calibration import reach
from lagrangian_ff.identification.mechanics.dynamics import Dynamics, least, no_lagrangian
from lagrangian_ff.identification.predicting import TorqueModel
from lagrangian_ff.identification.problem import Problem
from lagrangian_ff.identification.records import (
    Estimate,
    FittedEffect,
    JointOutliers,
    MassCheck,
    Outliers,
    Stretch,
)
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


def hyperparameters_of(problem: Problem) -> dict[str, tuple[float, ...]]:
    """Return by name one number for each joint, or one that is common to all."""
    gamma = problem.noise / len(problem.samples)
    if isinstance(problem.kernel, CoupledKernel):
        gamma = gamma[:1]
    found = {name: v.tolist() for name, v in problem.kernel.hyperparameters.items()}
    found["gamma"] = gamma.tolist()
    for term in problem.basis.terms:
        for name, value in term.shape.items():
            found.setdefault(f"{term.effect.name}.{name}", []).append(float(value))
    return {name: tuple(v[:1] if len(set(v)) == 1 else v) for name, v in found.items()}


def effects_of(
    posterior: Posterior, value: Floats, joints: tuple[str, ...], block: Ints
) -> tuple[FittedEffect, ...]:
    """Return every effect on every joint, its parameters with 90 % intervals.

    Args:
        value: (B,) the parameters found, which a constraint or another loss may have moved.
        block: (M,) the block of time that each training sample lies in.
    """
    away = reach(posterior, block)
    ends = np.stack([value, value - away, value + away], axis=1).tolist()
    return tuple(
        FittedEffect(
            term.effect.name,
            joints[term.joint],
            term.effect.formula,
            {
                parameter.name: Estimate(best, low, high, parameter.unit)
                for parameter, (best, low, high) in zip(
                    term.effect.parameters, ends[place], strict=True
                )
            },
            dict(term.shape),
            term.effect.shape_words(term.shape, joints),
        )
        for term, place in posterior.problem.basis.slices()
    )


def mass_check(model: TorqueModel) -> MassCheck:
    """Return where on the training motion the mass matrix is not positive definite."""
    reason = no_lagrangian(model)
    if reason:
        return MassCheck(words=reason)
    seen = np.flatnonzero(model.trained)
    motion = model.data.take(seen[evenly(len(seen), STATES)])
    values, directions = least(Dynamics(model).mass_matrix(motion.q, motion.qd))
    worst = int(np.argmin(values))
    joint = model.joints[int(np.argmax(np.abs(directions[worst])))]
    bad = values <= 0.0
    share, lowest = float(bad.mean()), float(values[worst])
    ranges = zip(motion.q[bad].T, model.joints, strict=True) if bad.any() else ()
    where = {name: (float(q.min()), float(q.max())) for q, name in ranges}
    found = f"least eigenvalue {lowest:.3g} kg·m², mostly {joint}"
    if bad.any():
        percent = f"{100.0 * share:.0f} %" if share >= 0.01 else "less than 1 %"
        words = (
            f"the mass matrix is not positive definite on {percent} of the training motion "
            f"({found}), {_place(where, motion.q, model.joints)}: there is no forward dynamics "
            "there, and gravity and Coriolis torques are to be doubted; identify with --positive"
        )
    else:
        words = f"the mass matrix is positive definite all along the training motion ({found})"
    return MassCheck(True, len(motion), share, lowest, joint, where, words)


def _place(where: Mapping[str, tuple[float, float]], q: Floats, joints: Sequence[str]) -> str:
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


def outliers_found(
    weight: Floats, threshold: Floats, motion: Motion, residual: Floats, missed: Floats
) -> Outliers:
    """Return the outliers, the torques that count less than half.

    Args:
        weight: (M, N) IRLS weight of each torque.
        threshold: (N,) N·m, beyond which the loss is linear.
        motion: M samples that the kernel is built on.
        residual: (M, N) N·m, torque minus the prediction of a fit without it.
        missed: (H, N) N·m, the same on motion held out.
    """
    off = outliers_of(weight)
    numbers = np.stack([off.mean(axis=0), threshold, np.median(np.abs(missed), axis=0)], axis=1)
    each = zip(motion.joints, numbers.tolist(), strict=True)
    joints = {name: JointOutliers(*three) for name, three in each}
    share, longest = float(off.mean()), _longest(off, motion)
    others = float(np.sqrt(np.mean(residual[~off] ** 2))) if not off.all() else None
    words = "Huber's loss: every torque counts at least half"
    if longest is not None and others is not None:
        most = sorted(joints.items(), key=lambda one: -one[1].share)
        named = ", ".join(f"{name} {one.share:.1%}" for name, one in most if one.share > 0.0)
        words = (
            f"Huber's loss: {share:.1%} of the torques count less than half ({named}); the longest "
            f"stretch is {longest.seconds:.2f} s of {longest.joint}, from {longest.begin:.2f} s "
            f"on. On blocks left out, the others are missed by {others:.3g} N·m"
        )
    return Outliers(share, joints, longest, others, words)


def _longest(off: Flags, motion: Motion) -> Stretch | None:
    """Return the longest time in which a joint's torque is an outlier without interruption."""
    if not off.any():
        return None
    step = usual_step(motion.time, motion.segment)
    found = []
    for joint, name in enumerate(motion.joints):
        here = np.where(off[:, joint], motion.segment, -1)
        edges = np.flatnonzero(np.diff(here, prepend=-2, append=-2))
        for first, last in zip(edges[:-1], edges[1:] - 1, strict=True):
            if off[first, joint]:
                length = float(motion.time[last] - motion.time[first]) + step
                found.append(Stretch(name, float(motion.time[first]), length))
    return max(found, key=lambda one: one.seconds)
