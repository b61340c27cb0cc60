"""What changed since the model was identified: friction, the arm's masses, or something new.

The data that the model keeps and a new recording are judged together, with one rigid-body part and
one set of effects for both. What then stands out in the new recording only has changed: each effect
is a candidate from the boundary on, and so is a second Lagrangian, which is what a load adds.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from lagrangian_ff.diagnosis.bodies import BodyChange, changed_bodies
from lagrangian_ff.diagnosis.ground import Changing, Ground, sharpen, tune
from lagrangian_ff.diagnosis.ground.ground import Extra
from lagrangian_ff.diagnosis.search.change import FELT, FINE, WORTH, joints_of
from lagrangian_ff.diagnosis.search.forward import MOST_STEPS, search
from lagrangian_ff.effects import EFFECTS, Effect, Inputs
from lagrangian_ff.effects.base import Floats
from lagrangian_ff.identification import Model, kept
from lagrangian_ff.identification.sliding import sliding_of
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording.motion import Motion, concatenate

PAUSE = 10.0  # s between the two, so that no block holds both
SINCE = " since"
MASSES = "rigid body"
"""The name of a change of masses, as by a load."""


@dataclass(frozen=True)
class Changed:
    """Something that is not as it was.

    Attributes:
        what: the effect, or `MASSES`.
        joints: that feel it.
        gain: nats of log evidence.
        p_value: of chance doing as well over all candidates; None where it was not drawn.
        parameters: by name its change, in the parameter's unit: (value, unit).
        size: N·m, root mean square of the torque it adds, on the first of the joints.
        deviations: by name the standard deviation of a parameter, where it is known.
        rivals: changes of a known robot's bodies that explain as much.
    """

    what: str
    joints: tuple[str, ...]
    gain: float
    p_value: float | None
    parameters: Mapping[str, tuple[float, str]]
    size: float
    deviations: Mapping[str, float] = field(default_factory=dict)
    rivals: tuple[str, ...] = ()

    def record(self) -> dict[str, object]:
        """For JSON."""
        return {
            "what": self.what,
            "joints": list(self.joints),
            "evidence_gain": self.gain,
            "p_value": self.p_value,
            "change": {
                name: {"value": value, "unit": unit, **self._interval(name, value)}
                for name, (value, unit) in self.parameters.items()
            },
            "size": self.size,
            "rivals": list(self.rivals),
        }

    def _interval(self, name: str, value: float) -> dict[str, float]:
        """The ends of a parameter's 90 % interval; empty where its deviation is not known."""
        if name not in self.deviations:
            return {}
        reach = 1.645 * self.deviations[name]
        return {"low": value - reach, "high": value + reach}


class _Later(Effect):
    """An effect that begins, or changes, at a boundary of time."""

    def __init__(self, effect: Effect, boundary: float) -> None:
        self._effect, self._boundary = effect, boundary
        for word in ("formula", "source", "meaning", "parameters", "shapes", "kind",
                     "coordinate", "remembers", "uses"):  # fmt: skip
            setattr(self, word, getattr(effect, word))
        setattr(self, "name", f"{effect.name}{SINCE}")  # noqa: B010

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        return self._effect.columns(x, joint, shape) * (x.time >= self._boundary)[:, None]

    def candidates(self, x: Inputs, joint: int) -> Sequence[Mapping[str, float]]:
        """See `Effect.candidates`."""
        return self._effect.candidates(x, joint)

    def cause(self, joint: int, shape: Mapping[str, float]) -> int:
        """See `Effect.cause`."""
        return self._effect.cause(joint, shape)


def changed_since(
    model: Model, motion: Motion, steps: int = MOST_STEPS, progress: Progress = silent
) -> tuple[Changed, ...]:
    """What is different in a recording from the data that a model was identified from.

    Args:
        model: with the data it keeps.
        motion: recorded later.
        steps: at most so many changes are looked for.
        progress: told the share done.

    Returns:
        The changes, in the order in which they were found; empty where nothing stands out.

    Raises:
        RecordingError: the motion lacks a joint of the model.
    """
    new = kept(motion.select(model.joints))
    boundary = float(model.data.time.max()) + PAUSE
    new = replace(new, time=new.time - new.time[0] + boundary)
    both = concatenate([model.data, new])
    sliding = sliding_of(model.kernel, len(model.joints))
    # Under names of their own, since the model's own effects may have changed as well.
    later = [_Later(effect, boundary) for effect in EFFECTS.values() if effect.kind != "event"]
    # Handed on and not kept: each ground holds a factor.
    found: list[Changed] = []
    done = search(
        _bodies(
            tune(both, model.inputs_of(both), model.basis, part(progress, 0.0, 0.4), sliding),
            model,
            boundary,
            found,
        ),
        {effect.name: effect for effect in later},
        steps,
        part(progress, 0.5, 1.0),
    )
    for step in done.steps:
        if step.named:
            score = step.score
            found.append(
                Changed(
                    score.candidate.source.name.removesuffix(SINCE),
                    (model.joints[score.candidate.joint],),
                    score.gain,
                    step.p_value,
                    {
                        one.name: (float(value), one.unit)
                        for one, value in zip(
                            score.candidate.effect.parameters, score.coefficients, strict=True
                        )
                    },
                    score.size,
                )
            )
    return tuple(found)


def _bodies(ground: Ground, model: Model, boundary: float, found: list[Changed]) -> Ground:
    """Return the ground with masses that changed explained, which are added to what was found."""
    named = changed_bodies(model, ground, boundary)
    heavier = _masses(ground, boundary)
    if named is not None and named.gain > WORTH:
        found.append(_named(named, ground, model))
        return _explained(heavier[0] if heavier else ground, named)
    if heavier is None:
        return ground
    ground, change = heavier
    felt, _ = joints_of(ground)
    found.append(replace(change, joints=tuple(model.joints[n] for n in felt)))
    return ground


def _named(change: BodyChange, ground: Ground, model: Model) -> Changed:
    """A change of a known robot's bodies as what changed."""
    rms = np.sqrt(np.mean(change.torque**2, axis=0))
    order = [int(n) for n in np.argsort(-rms / ground.spread)]
    felt = [n for n in order if rms[n] > FELT * ground.spread[n]] or order[:1]
    return Changed(
        change.what,
        tuple(model.joints[n] for n in felt),
        change.gain,
        None,
        {name: (value, unit) for name, (value, _, unit) in change.parameters.items()},
        float(rms[felt[0]]),
        {name: deviation for name, (_, deviation, _) in change.parameters.items()},
        change.rivals,
    )


def _explained(ground: Ground, change: BodyChange) -> Ground:
    """The ground with the torque of a change explained away."""
    extra = [Extra(n, change.torque[:, n : n + 1]) for n in range(ground.joints)]
    return ground.relaid(extra=(*ground.extra, *extra))


def _masses(ground: Ground, boundary: float) -> tuple[Ground, Changed] | None:
    """The ground with another Lagrangian added from the boundary on, if that is worth it."""
    changing = Changing.of(ground, len(ground.index))
    gain, share = max((changing.gain((boundary, np.inf, one)), one) for one in FINE)
    if gain < WORTH:
        return None
    prior = replace(ground.prior, change=(boundary, np.inf, share))
    heavier = ground.relaid(sharpen(ground, ground.basis, prior=prior))
    _, felt = joints_of(heavier)
    size = float(np.max(felt) * heavier.spread[int(np.argmax(felt))])
    return heavier, Changed(MASSES, (), gain, None, {}, size)
