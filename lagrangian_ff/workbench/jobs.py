"""The work of the workbench, each in its own process: a request, and what the page shows of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangian_ff.progress import Progress, part
from lagrangian_ff.record_json import finite
from lagrangian_ff.workbench.settings import Reading, told, with_lag
from lagrangian_ff.workbench.shown import described, finding_card, left_over, proposals_cards

if TYPE_CHECKING:
    from lagrangian_ff.identification import Model
    from lagrangian_ff.recording import Motion

MOST_TRIED = 4
Record = dict[str, Any]


@dataclass(frozen=True)
class Learn:
    """Identify a model.

    Attributes:
        output: the file to write.
        sources: files of recordings.
        model: kernel and effects, as `identify --model` names them.
        urdf: the file of a description whose bodies are taken; empty for none.
        reading: how the recordings are read.
    """

    output: str
    sources: tuple[str, ...]
    model: str
    urdf: str = ""
    reading: Reading = field(default_factory=Reading)

    def work(self, progress: Progress) -> Record:
        """Write the model and return its errors."""
        from lagrangian_ff.identification import Settings, identify, joint_order
        from lagrangian_ff.recording import load

        robot = None
        if self.urdf:
            from lagrangian_ff.kernels.rigid import read_urdf

            robot = read_urdf(self.urdf)
        progress(0.0, "reading")
        motions = self.reading.ready(self.sources, [load(source) for source in self.sources])
        order = joint_order(motions, self.model, robot, part(progress, 0.1, 0.2))
        motions = [motion.select(order.joints) for motion in motions]
        given = Settings(model=self.model, train=1.0)
        found = identify(motions, given, part(progress, 0.2, 1.0), robot)
        found.model.save(Path(self.output))
        return described(found.model)


@dataclass(frozen=True)
class Compare:
    """Compare a model with recordings, and write what is drawn of it.

    Attributes:
        output: the file of arrays to write, see `traces`.
        page: the file of the report to write.
        model: its file.
        sources: files of recordings, compared together.
        effects: the file of the user's formulas; empty for none.
        reading: how the recordings are read.
        learned: share of each stretch of each recording that the model learned from; the rest is
            compared.
        stretch: s, see `learned_and_unseen`.
    """

    output: str
    page: str
    model: str
    sources: tuple[str, ...]
    effects: str = ""
    reading: Reading = field(default_factory=Reading)
    learned: float = 0.0
    stretch: float = float("inf")

    def work(self, progress: Progress) -> Record:
        """Write the arrays; return the errors per joint and where most of them lie."""
        import numpy as np

        from lagrangian_ff.diagnosis import compare
        from lagrangian_ff.diagnosis.preflight import preflight
        from lagrangian_ff.diagnosis.where import Compared, locate
        from lagrangian_ff.investigation.stretches import learned_and_unseen
        from lagrangian_ff.kernels.threads import one_blas_thread
        from lagrangian_ff.recording import concatenate
        from lagrangian_ff.report import compare_page
        from lagrangian_ff.workbench import traces

        model = load_model(self.model, self.effects)
        reading = part(progress, 0.0, 0.2)
        motions = motions_for(self.model, model, self.sources, reading, self.reading)
        if self.learned:
            _, motions = learned_and_unseen(motions, self.learned, self.stretch)
        motion = concatenate(motions)
        with one_blas_thread():
            checks = preflight(model, motion, kind=False)
            found = compare(model, motion, part(progress, 0.2, 0.6), intervals=True)
            where = locate(model, found, part(progress, 0.6, 0.95))
        progress(0.95, "writing the page")
        compare_page(self.page, Compared(self.model, self.sources, where))
        motion = where.series.motion
        time = traces.running_time(motion.time, motion.segment)
        regions = []
        for one in where.regions:
            n = model.joints.index(one.joint)
            held = [condition.holds(where.series, n) for condition in one.conditions]
            spans = traces.spans(time, np.logical_and.reduce(held))
            regions.append({"joint": one.joint, "words": one.words, "spans": spans})
        return finite({
            **found.record(),
            "joint_names": list(model.joints),
            "seconds": traces.write(Path(self.output), found),
            "regions": regions,
            "words": where.words(),
            "warning": found.warning,
            "checks": [told(one) for one in checks if one.serious],
        })  # fmt: skip


@dataclass(frozen=True)
class Search:
    """Find out which effects a model lacks.

    Attributes:
        page: the file of the report to write.
        model: its file.
        sources: files of recordings that are searched.
        confirm: those that confirm; empty for the last third of the others.
        effects: the file of the user's formulas; empty for none.
        reading: how the recordings are read.
    """

    page: str
    model: str
    sources: tuple[str, ...]
    confirm: tuple[str, ...]
    effects: str = ""
    reading: Reading = field(default_factory=Reading)

    def work(self, progress: Progress) -> Record:
        """Return the verdict, a card for each finding, and what cannot be seen here."""
        from lagrangian_ff.diagnosis import (
            DiagnosisRun,
            Round,
            diagnose,
            verdict,
            with_consequences,
        )
        from lagrangian_ff.diagnosis.preflight import preflight
        from lagrangian_ff.kernels.threads import one_blas_thread
        from lagrangian_ff.recording import concatenate
        from lagrangian_ff.report import diagnose_page

        model = load_model(self.model, self.effects)
        given, reading = self.reading, part(progress, 0.0, 0.1)
        motions = motions_for(self.model, model, self.sources, reading, given)
        confirm = motions_for(self.model, model, self.confirm, reading, given)
        with one_blas_thread():
            checks = preflight(model, concatenate(motions), confirm)
            found = diagnose(model, motions, confirm, progress=part(progress, 0.15, 0.75))
            found = with_consequences(found, part(progress, 0.75, 0.97))
        rounds = (Round(found),)
        run = DiagnosisRun(self.model, self.sources, self.confirm, rounds, tuple(checks))
        diagnose_page(self.page, run)
        return finite({
            "verdict": verdict(found),
            "checks": [told(one) for one in with_lag(found, checks) if one.advice],
            "on": list(self.sources),
            "findings": [finding_card(one, found) for one in found.findings],
            **left_over(found),
            "not_observable": [
                {"effect": one.effect, "joint": one.joint, "reason": one.reason,
                 "motion": one.next_motion}
                for one in found.not_observable
            ],
        })  # fmt: skip


@dataclass(frozen=True)
class Add:
    """Add an effect to a model.

    Attributes:
        output: the file to write.
        model: the file of the model before.
        effect, joint: names.
        shape: its nonlinear parameters; those not given are searched.
        why: for the model's history.
        effects: the file of the user's formulas; empty for none.
        form: of a curve, `over` and `friction` as `diagnosis.add` takes them.
    """

    output: str
    model: str
    effect: str
    joint: str
    shape: Mapping[str, float] = field(default_factory=dict)
    why: Mapping[str, object] = field(default_factory=dict)
    effects: str = ""
    form: Mapping[str, Any] = field(default_factory=dict)

    def work(self, progress: Progress) -> Record:
        """Write the model with the effect, and return its errors."""
        from lagrangian_ff.diagnosis import add

        before = load_model(self.model, self.effects)
        shape = dict(self.shape) or None
        why = dict(self.why)
        after = add(before, self.effect, self.joint, shape, why, progress, **self.form)
        after.save(Path(self.output))
        return described(after)


@dataclass(frozen=True)
class Propose:
    """Propose formulas for what a model lacks on a joint, or holds as a curve there.

    Attributes:
        model: its file.
        joint: its name.
        sources, confirm, effects, reading: as of `Search`.
    """

    model: str
    joint: str
    sources: tuple[str, ...]
    confirm: tuple[str, ...]
    effects: str = ""
    reading: Reading = field(default_factory=Reading)

    def work(self, progress: Progress) -> Record:
        """Return a card for each formula, and what they competed with."""
        from lagrangian_ff.diagnosis.proposing import propose
        from lagrangian_ff.kernels.threads import one_blas_thread

        model = load_model(self.model, self.effects)
        given, reading = self.reading, part(progress, 0.0, 0.1)
        motions = motions_for(self.model, model, self.sources, reading, given)
        confirm = motions_for(self.model, model, self.confirm, reading, given)
        report = part(progress, 0.1, 1.0)
        with one_blas_thread():
            return proposals_cards(propose(model, motions, confirm, self.joint, progress=report))


@dataclass(frozen=True)
class WhatIf:
    """Try every combination of effects, on motion that took no part.

    Attributes:
        model: the file of the model without them.
        sources: files of the recordings to judge on.
        tried: effect, joint and shape of each; at most `MOST_TRIED`.
        effects: the file of the user's formulas; empty for none.
        reading: how the recordings are read.
    """

    model: str
    sources: tuple[str, ...]
    tried: tuple[tuple[str, str, Mapping[str, float]], ...]
    effects: str = ""
    reading: Reading = field(default_factory=Reading)

    def work(self, progress: Progress) -> Record:
        """Return the rms error with each combination; None for effects that exclude each other."""
        from lagrangian_ff.diagnosis import add, compare
        from lagrangian_ff.errors import ModelError
        from lagrangian_ff.kernels.threads import one_blas_thread
        from lagrangian_ff.recording import concatenate

        model = load_model(self.model, self.effects)
        reading = part(progress, 0.0, 0.1)
        motion = concatenate(motions_for(self.model, model, self.sources, reading, self.reading))
        numbers = range(len(self.tried))
        every = [one for size in range(len(numbers) + 1) for one in combinations(numbers, size)]
        made: dict[tuple[int, ...], Model | None] = {(): model}
        found = []
        with one_blas_thread():
            for number, chosen in enumerate(every):
                progress(0.1 + 0.9 * number / len(every), f"{number} of {len(every)} combinations")
                before = made[chosen[:-1]]
                if chosen and before is not None:
                    effect, joint, shape = self.tried[chosen[-1]]
                    try:
                        made[chosen] = add(before, effect, joint, dict(shape) or None)
                    except ModelError:  # it has the effect by another name
                        made[chosen] = None
                after = made.setdefault(chosen, None)
                error = None if after is None else compare(after, motion).score.total
                found.append({"with": list(chosen), "rmse": error})
        names = [f"{effect.replace('_', ' ')} on {joint}" for effect, joint, _ in self.tried]
        return finite({"names": names, "combinations": found})


def load_model(file: str, effects: str) -> "Model":
    """Return a saved model; the user's formulas are loaded first, since it may have some."""
    from lagrangian_ff.effects.user import load_effects
    from lagrangian_ff.identification import Model

    if effects:
        load_effects(effects)
    return Model.load(file)


def motions_for(
    file: str,
    model: "Model",
    sources: tuple[str, ...],
    progress: Progress,
    reading: Reading | None = None,
) -> "list[Motion]":
    """Return the motions in recordings, read as those were that the model was identified from.

    Args:
        reading: the scales of their efforts; None is that of the model for all.
    """
    from lagrangian_ff.recording import Conditioning, condition_alike, load

    recordings = []
    for number, source in enumerate(sources):
        progress(number / len(sources), f"reading {Path(source).name}")
        recording = load(source)
        model.require_joints(recording.joints, recording.source, file)
        recordings.append(recording.select(model.joints))
    if not recordings:
        return []
    before = model.identified.conditioning or Conditioning()
    if reading is None:
        return condition_alike(recordings, before)
    return reading.ready(sources, recordings, before)
