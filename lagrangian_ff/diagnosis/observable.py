"""What a motion could show of each effect on each joint, before any model is learned."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.results import NotObservable
from lagrangian_ff.diagnosis.search.bayes_factor import bayes_factors
from lagrangian_ff.diagnosis.search.candidates import named, searched_for
from lagrangian_ff.diagnosis.search.visible import clearest, hidden, still
from lagrangian_ff.diagnosis.whitening import fit
from lagrangian_ff.effects import Effect, Inputs
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.identification import decimated
from lagrangian_ff.identification.build import seconds
from lagrangian_ff.identification.problem import Problem, Scaling
from lagrangian_ff.identification.samples import Samples
from lagrangian_ff.identification.settings import usual_model
from lagrangian_ff.identification.spec import parse
from lagrangian_ff.kernels import States
from lagrangian_ff.numbers import percent
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.record_json import finite
from lagrangian_ff.recording.motion import Motion, concatenate

KERNEL = "chain"
"""Of the rigid bodies that an effect must show beside, as in `diagnose`."""


@dataclass(frozen=True)
class Observability:
    """What a motion could show.

    Attributes:
        joints: N names.
        least: by effect, N shares of the joints' torque: from this size on `diagnose` expects
            enough evidence to see it there. Infinite where no size shows, as on a joint that
            stands still.
        not_observable: the effects that are hidden at `size`, and why.
        size: share of a joint's torque that an effect should be seen at.
    """

    joints: tuple[str, ...]
    least: Mapping[str, tuple[float, ...]]
    not_observable: tuple[NotObservable, ...]
    size: float

    def shown(self, effect: str) -> tuple[str, ...]:
        """Return the joints on which an effect of `size` would be seen."""
        pairs = zip(self.joints, self.least[effect], strict=True)
        return tuple(joint for joint, least in pairs if least <= self.size)

    @property
    def words(self) -> str:
        """Return one sentence on how many effects the motion shows."""
        every = [len(self.shown(effect)) for effect in self.least]
        whole = sum(count == len(self.joints) for count in every)
        none = sum(count == 0 for count in every)
        text = (
            f"effects of {percent(self.size)} of a joint's torque would be seen: "
            f"{whole} of {len(every)} on every joint"
        )
        if some := len(every) - whole - none:
            text += f", {some} on some"
        return text + (f", {none} on none" if none else "")

    def record(self) -> dict[str, object]:
        """Return it for JSON, with None for no size."""
        named = {n: dict(zip(self.joints, row, strict=True)) for n, row in self.least.items()}
        return finite({
            "size": self.size,
            "words": self.words,
            "least": named,
            "not_observable": [asdict(one) for one in self.not_observable],
        })  # fmt: skip


def observability(
    motion: Motion | Sequence[Motion],
    effects: Mapping[str, Effect] | None = None,
    sliding: Sequence[int] = (),
    progress: Progress = silent,
) -> Observability:
    """Return the least size at which each effect would be seen on each joint of a motion.

    The effect adds to a serial arm of unknown masses with plain friction. Half of the squared size
    of its whitened columns, less the price of its parameters, is the log Bayes factor to be
    expected; the least size makes it `floor`.

    Args:
        motion: measured, or several of the same joints, these from the base to the tool.
        effects: those to look at; None takes the whole catalogue.
        sliding: indices of the joints that slide.
        progress: receives the share done, 0 to 1.

    Raises:
        RecordingError: there is too little motion.
    """
    motions = [motion] if isinstance(motion, Motion) else motion
    whole = concatenate([decimated(one) for one in motions])
    if (length := seconds(whole)) < thresholds.USED.shortest:
        raise RecordingError(
            f"{whole.source}: {length:.1f} s of motion, expected at least "
            f"{thresholds.USED.shortest:g} s to see any effect by"
        )
    states = States(whole.q, whole.qd, whole.qdd)
    inputs = Inputs.of(states, whole.time, whole.segment, temperature=whole.temperature)
    name = usual_model(whole.effort).replace("auto", KERNEL)
    spec = replace(parse(name), sliding=tuple(sliding))
    samples = Samples(inputs, whole.tau)
    basis = Problem.started(spec, samples, Scaling.of(whole.tau, per_joint=False)).basis
    slides = np.isin(np.arange(len(whole.joints)), sliding).astype(np.float64)
    whitened = fit(whole, inputs, basis, part(progress, 0.0, 0.8), slides)
    progress(0.8, "looking at every effect")
    sought = effects or searched_for(whole.effort, basis)
    candidates = named(whitened.x, whitened.basis, range(whitened.joints), sought)
    best = clearest(bayes_factors(whitened, candidates, coarse=True))
    progress(1.0, "looking at every effect")
    stands = still(whole)
    least: dict[str, list[float]] = {}
    for (effect, joint), score in best.items():
        row = least.setdefault(effect, [np.inf] * len(whole.joints))
        row[joint] = np.inf if stands[joint] else score.least_size(thresholds.USED.floor)
    return Observability(
        whole.joints,
        {effect: tuple(row) for effect, row in least.items()},
        hidden(best, whole, whole.joints),
        thresholds.USED.observable_size,
    )
