"""Which torques a fit with Huber's loss weighed down: a share, and the longest stretch."""

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification.solving.robust import HALF
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


def doubtful(trust: Floats) -> Bools:
    """(M, N) which torques count less than half, for the trust (M, N) in them."""
    return np.asarray(trust < HALF)


def outlier_record(
    trust: Floats, threshold: Floats, motion: Motion, residual: Floats, missed: Floats
) -> dict[str, object]:
    """For JSON, with one sentence for people.

    Args:
        trust: (M, N) in each torque.
        threshold: (N,) N·m, beyond which the loss is linear.
        motion: M samples the kernel is built on.
        residual: (M, N) N·m, torque minus the prediction of a fit that did not see it.
        missed: (H, N) N·m, the same of the model on motion held out.

    Returns:
        `share` of all torques that count less than half, and by joint; by joint, too, `threshold`
        and `held_out_median`, which half of the torques held out are missed by less than, in N·m;
        `longest`, the longest stretch of them, with its joint, begin and length in s;
        `rmse_of_others` in N·m on blocks left out, of the other torques; `words`.
    """
    off = doubtful(trust)
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


def _longest(off: Bools, motion: Motion) -> dict[str, object] | None:
    """The longest time in which a joint's torque is doubtful without interruption."""
    if not off.any():
        return None
    steps = np.diff(motion.time)[np.diff(motion.segment) == 0]
    step = float(np.median(steps)) if len(steps) else 0.0
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
