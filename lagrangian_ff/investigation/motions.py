"""The motions of an investigation: within which limits, for how large effects, by which model."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis import apply
from lagrangian_ff.diagnosis.confidence import Verdict
from lagrangian_ff.diagnosis.excite import Limits, Question, Reference, excite
from lagrangian_ff.diagnosis.excite.assumed import SIZE
from lagrangian_ff.diagnosis.excite.keeping import Clear, jerk_of
from lagrangian_ff.diagnosis.results import Diagnosis, Finding
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model, extend

SHORTEST = 8.0
"""s of motion that are worth beginning."""
SMALLER = (1.0, 0.8, 0.6, 0.45, 0.3, 0.2)
"""Shares of the permitted range that a first motion tries, until it touches nothing."""
INSIDE = 0.98
"""Share of the tempo at which a first motion would just keep its jerk."""

Named: TypeAlias = tuple[str, str]
"""An effect and its joint."""


def first_motion(
    joints: tuple[str, ...],
    limits: Limits,
    start: Floats,
    seconds: float,
    *,
    seed: int = 0,
    clear: Clear | None = None,
) -> Reference:
    """Return a motion of all joints, in a smaller range where it would touch something.

    Args:
        start: (N,) rad, where it begins and ends.  seconds: how long it lasts.
        clear: says what touches on a path; None if nothing is known of that.

    Raises:
        ModelError: it touches something in every range.
    """

    def exciting(within: Limits, lasts: float) -> Reference:
        while True:
            motion = excite("exciting", joints, within, start=start, duration=lasts, seed=seed)
            if limits.jerk_max is None:
                return motion
            over = float(np.max(np.abs(jerk_of(motion)).max(axis=0) / limits.jerk_max))
            if over <= 1.0:
                return motion
            within = within.gentler(INSIDE * over ** (-1.0 / 3.0))

    for share in SMALLER:
        within = limits.around(start, share)
        motion = exciting(within, seconds)
        if (took := float(motion.time[-1])) > seconds:
            # What leads there and back comes on top of the time that was asked for.
            motion = exciting(within, max(SHORTEST, 2 * seconds - took))
        touches = "" if clear is None else clear(motion.q)
        if not touches:
            return motion
    raise ModelError(
        f"every first motion from this start would touch something ({touches}): begin elsewhere"
    )


def both(permitted: Limits, seen: Limits, start: Floats) -> Limits:
    """Return the limits within both: what was permitted, and what the model has seen.

    Where jerk and torque were permitted, that counts alone: of states inside, a model predicts the
    torque, and no model of ours knows of jerk.

    Args:
        start: (N,) rad, where all motions begin: it is inside, also at the end of a range.
    """
    return replace(
        seen,
        q_low=np.minimum(np.maximum(permitted.q_low, seen.q_low), start),
        q_high=np.maximum(np.minimum(permitted.q_high, seen.q_high), start),
        qd_max=np.minimum(permitted.qd_max, seen.qd_max),
        qdd_max=np.minimum(permitted.qdd_max, seen.qdd_max),
        jerk_max=seen.jerk_max if permitted.jerk_max is None else permitted.jerk_max,
        tau_max=seen.tau_max if permitted.tau_max is None else permitted.tau_max,
    )


def for_design(
    found: Diagnosis, question: Question, made: dict[tuple[Named, ...], Model] | None = None
) -> Model:
    """Return the model with all that unseen motion confirms, also what no error falls by yet.

    What is missing is noise that hides the rest. Of two that cannot be told apart one is added, in
    place of both. What is asked for is left out.

    Args:
        made: models that were fitted for the same diagnosis, by the effects that were added.
            One of them is returned if it fits; else the new one is put in.
    """
    made = {} if made is None else made
    wanted = {(one.effect, one.joint) for one in question.suspects}
    added = [
        one
        for one in found.findings
        if one.useless or (one.verdict is Verdict.AMBIGUOUS and not one.once)
        if wanted.isdisjoint((name, one.joint) for name in (one.effect.name, *one.rivals))
    ]
    names = tuple((one.effect.name, one.joint) for one in added)
    if names not in made:
        model = apply(found)
        for one in added:
            with suppress(ModelError):  # the model has it by another name
                model = extend(model, one.effect, one.joint, one.shape).model
        made[names] = model
    return made[names]


def size_of(found: Sequence[Finding], question: Question, model: Model) -> float:
    """Return the share of its joint's torque that an effect asked about has, where it was found.

    Of others it is as large as an effect is taken to be.
    """
    asked_for = {(one.effect, one.joint) for one in question.suspects}
    for one in found:
        if (one.effect.name, one.joint) in asked_for:
            spread = float(np.std(model.data.tau[:, model.joints.index(one.joint)]))
            return min(1.0, one.size / spread)
    return SIZE
