"""What adding the findings does to the model's own error on motion that no search has seen."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.compare import compare
from lagrangian_ff.diagnosis.diagnose import CONFIRMED, Diagnosis, Finding
from lagrangian_ff.diagnosis.reason import for_history
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model, extend
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

BLOCK_SECONDS = 3.0
MOST = 4
"""Findings for which the model is refitted; the others are told without."""


@dataclass(frozen=True)
class Consequence:
    """One finding added to the model and what came before it.

    Attributes:
        model: with the finding.
        before, after: (B,) N·m, error of the joint in each block of the unseen motion.
        time: (B,) s since the beginning, where the blocks begin.
        whole_before, whole_after: N·m, over all of it.
        every_before, every_after: N·m, over all joints.
    """

    model: Model
    time: Floats
    before: Floats
    after: Floats
    whole_before: float
    whole_after: float
    every_before: float
    every_after: float


def consequences(diagnosis: Diagnosis, progress: Progress = silent) -> dict[Finding, Consequence]:
    """Add the findings one after the other, each to the model that has the confirmed ones before.

    Findings that are no more than suggested are tried, and left out again.
    """
    model, motion = diagnosis.model, diagnosis.unseen
    error = compare(model, motion).residual
    made: dict[Finding, Consequence] = {}
    chosen: Sequence[Finding] = diagnosis.findings[:MOST]
    for number, finding in enumerate(chosen):
        progress(number / len(chosen), f"adding {finding.effect.name} to see the error fall")
        try:
            why = for_history(finding, diagnosis)
            larger = extend(model, finding.effect, finding.joint, finding.shape, why).model
        except ModelError:
            continue
        new = compare(larger, motion).residual
        made[finding] = _between(larger, motion, finding.joint, error, new)
        if finding.verdict == CONFIRMED:
            model, error = larger, new
    progress(1.0, "adding what was found")
    return made


def _between(
    model: Model, motion: Motion, joint: str, before: Floats, after: Floats
) -> Consequence:
    column = model.joints.index(joint)
    block = motion.blocks(BLOCK_SECONDS)
    starts = np.flatnonzero(np.diff(block, prepend=-1))
    counts = np.diff([*starts, len(block)])

    def by_block(error: Floats) -> Floats:
        sums = np.add.reduceat(error[:, column] ** 2, starts)
        return np.asarray(np.sqrt(sums / counts))

    def rms(error: Floats) -> float:
        return float(np.sqrt(np.mean(error**2)))

    return Consequence(
        model,
        motion.elapsed[starts],
        by_block(before),
        by_block(after),
        rms(before[:, column]),
        rms(after[:, column]),
        rms(before),
        rms(after),
    )
