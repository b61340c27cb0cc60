"""Changes since the model was identified: in friction, in the arm's masses, or new effects.

One problem holds the data that the model keeps and a new recording, with one rigid-body part and
one set of effects for both. Whatever stands out in the new recording only has changed: each effect
is a candidate from the boundary on, and so is a second Lagrangian, as a load adds it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.bodies import BodyChange, changed_bodies
from lagrangian_ff.diagnosis.run import Changed
from lagrangian_ff.diagnosis.search.change import FINE, joints_of
from lagrangian_ff.diagnosis.search.forward import MOST_STEPS, search
from lagrangian_ff.diagnosis.whitening import Changing, Whitened, fit, refit
from lagrangian_ff.effects import EFFECTS, Effect, Inputs
from lagrangian_ff.effects.base import Floats
from lagrangian_ff.identification import Model, decimated
from lagrangian_ff.identification.problem import Nuisance
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.identification.spec import sliding_of
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording.motion import Motion, concatenate

PAUSE = 10.0  # s between the two recordings, so that no block holds both
SINCE = " since"
MASSES = "rigid body"
"""The name of a change of masses, as by a load."""


class _Later(Effect):
    """An effect that begins, or changes, at a boundary of time."""

    def __init__(self, effect: Effect, boundary: float) -> None:
        self._effect, self._boundary = effect, boundary
        names = "formula source meaning parameters shapes kind coordinate remembers uses"
        for name in names.split():
            setattr(self, name, getattr(effect, name))
        setattr(self, "name", f"{effect.name}{SINCE}")  # noqa: B010

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        return self._effect.columns(x, joint, shape) * (x.time >= self._boundary)[:, None]

    def candidates(self, x: Inputs, joint: int) -> Sequence[Mapping[str, float]]:
        return self._effect.candidates(x, joint)

    def cause(self, joint: int, shape: Mapping[str, float]) -> int:
        return self._effect.cause(joint, shape)


def changed_since(
    model: Model, motion: Motion, steps: int = MOST_STEPS, progress: Progress = silent
) -> tuple[Changed, ...]:
    """Return the changes from the data that a model keeps to a recording, in the order found.

    Args:
        model: with its data.  motion: recorded later.
        steps: the largest number of changed effects to find.
        progress: receives the share done, 0 to 1.

    Raises:
        RecordingError: the motion lacks a joint of the model.
    """
    new = decimated(motion.select(model.joints))
    boundary = float(model.data.time.max()) + PAUSE
    new = replace(new, time=new.time - new.time[0] + boundary)
    both = concatenate([model.data, new])
    sliding = sliding_of(model.kernel, len(model.joints))
    # Under other names, since the effects that the model has may have changed as well.
    lasting = (effect for effect in EFFECTS.values() if effect.kind != "event")
    later = {one.name: one for one in (_Later(effect, boundary) for effect in lasting)}
    inputs = model.inputs_of(both)
    fitting, searching = part(progress, 0.0, 0.4), part(progress, 0.5, 1.0)
    found: list[Changed] = []
    # The whitened motion is not kept in a variable: it holds a factor of some 200 MB.
    done = search(
        _bodies(fit(both, inputs, model.basis, fitting, sliding), model, boundary, found),
        later,
        steps,
        searching,
    )
    for step in done.steps:
        if step.named:
            score, candidate = step.score, step.score.candidate
            values = zip(candidate.effect.parameters, score.coefficients.tolist(), strict=True)
            changes = {one.name: Estimate(value, unit=one.unit) for one, value in values}
            what = candidate.source.name.removesuffix(SINCE)
            joints = (model.joints[candidate.joint],)
            found.append(Changed(what, joints, score.log_bf, step.p_value, changes, score.size))
    return tuple(found)


def _bodies(whitened: Whitened, model: Model, boundary: float, found: list[Changed]) -> Whitened:
    """Return the motion with a change of masses explained, and append that change to `found`."""
    named = changed_bodies(model, whitened, boundary)
    heavier = _masses(whitened, model, boundary)
    if named is not None and named.log_bayes_factor > thresholds.USED.change_floor:
        found.append(_named(named, whitened, model))
        return _explained(heavier[0] if heavier else whitened, named)
    if heavier is None:
        return whitened
    found.append(heavier[1])
    return heavier[0]


def _named(change: BodyChange, whitened: Whitened, model: Model) -> Changed:
    """Return a change of a known robot's bodies as a result."""
    rms = np.sqrt(np.mean(change.torque**2, axis=0))
    order = [int(n) for n in np.argsort(-rms / whitened.spread)]
    felt = [n for n in order if rms[n] > thresholds.USED.felt * whitened.spread[n]] or order[:1]
    joints, size = tuple(model.joints[n] for n in felt), float(rms[felt[0]])
    nats = change.log_bayes_factor
    return Changed(change.what, joints, nats, None, change.parameters, size, change.rivals)


def _explained(whitened: Whitened, change: BodyChange) -> Whitened:
    """Return the motion with the torque of a change explained."""
    extra = [Nuisance(n, change.torque[:, n : n + 1]) for n in range(whitened.joints)]
    return whitened.explaining(whitened.basis, (*whitened.problem.nuisance, *extra))


def _masses(whitened: Whitened, model: Model, boundary: float) -> tuple[Whitened, Changed] | None:
    """Return the motion with a second Lagrangian from the boundary on, if strongly needed."""
    changing = Changing.of(whitened, len(whitened.index))
    log_bf, share = max((changing.log_bayes_factor((boundary, np.inf, one)), one) for one in FINE)
    if log_bf < thresholds.USED.change_floor:
        return None
    problem = refit(whitened, whitened.basis, change=(boundary, np.inf, share))
    heavier = whitened.assuming(problem)
    felt, share_felt = joints_of(heavier)
    size = float(np.max(share_felt) * heavier.spread[int(np.argmax(share_felt))])
    names = tuple(model.joints[n] for n in felt)
    return heavier, Changed(MASSES, names, log_bf, None, {}, size)
