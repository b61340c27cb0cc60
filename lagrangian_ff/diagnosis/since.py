"""Changes since the model was identified: in friction, in drives' gains, in masses, or new effects.

One problem holds the data that the model keeps and a new recording, with one rigid-body part and
one set of effects for both. Whatever stands out in the new recording only has changed. First single
causes compete that change much at once: another gain of a joint's drive, other masses, as by a
load, and other friction of a joint. Gains and masses are then explained, and each effect is a
candidate from the boundary on.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.compare import OUTSIDE
from lagrangian_ff.diagnosis.competing import Cause, without_causes
from lagrangian_ff.diagnosis.misfit import misfit_of
from lagrangian_ff.diagnosis.run import Changed
from lagrangian_ff.diagnosis.search.forward import MOST_STEPS, search
from lagrangian_ff.diagnosis.search.hold_out import frozen
from lagrangian_ff.effects import EFFECTS, Effect, Inputs
from lagrangian_ff.effects.base import Floats
from lagrangian_ff.identification import Model, decimated
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording.motion import Motion, concatenate

PAUSE = 10.0  # s between the two recordings, so that no block holds both
SINCE = " since"


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

    def signs(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Mapping[str, Floats]:
        """Return nothing: what nature has above zero may have become less."""
        return {}

    def candidates(self, x: Inputs, joint: int) -> Sequence[Mapping[str, float]]:
        return self._effect.candidates(x, joint)

    def cause(self, joint: int, shape: Mapping[str, float]) -> int:
        return self._effect.cause(joint, shape)


class _Friction(Effect):
    """Other Coulomb and viscous friction of a joint from a boundary of time on, as one cause."""

    name = "coulomb and viscous"
    formula = "F_c tanh(qd / v0) + B qd"
    parameters = (*EFFECTS["coulomb"].parameters, *EFFECTS["viscous"].parameters)
    plain = True

    def __init__(self, boundary: float) -> None:
        self._boundary = boundary

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        qd = x.qd[:, joint]
        both = np.column_stack([np.tanh(qd / x.sign_speed[joint]), qd])
        return np.asarray(both * (x.time >= self._boundary)[:, None])


def changed_since(
    model: Model, motion: Motion, steps: int = MOST_STEPS, progress: Progress = silent
) -> tuple[Changed, ...]:
    """Return the changes from the data that a model keeps to a recording.

    A change that hardly lowers the error of the model on the recording is left out.

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
    # Under other names, since the effects that the model has may have changed as well.
    lasting = (one for one in EFFECTS.values() if one.kind != "event" and one.observable)
    effects = [_Friction(boundary), *(_Later(effect, boundary) for effect in lasting)]
    later = {one.name: one for one in effects}
    causes: list[Cause] = []
    # The whitened motion is not kept in a variable: it holds a factor of some 200 MB.
    done = search(
        without_causes(model, both, boundary, causes, part(progress, 0.0, 0.5)),
        later,
        steps,
        part(progress, 0.5, 1.0),
    )
    x = done.whitened.x
    for step, (values, low, high) in zip(done.steps, frozen(done), strict=True):
        if step.named:
            score, candidate = step.score, step.score.candidate
            ends = zip(candidate.effect.parameters, values, low, high, strict=True)
            changes = {
                one.name: Estimate(float(value), float(a), float(b), one.unit)
                for one, value, a, b in ends
            }
            if isinstance(candidate.effect, _Friction):  # what surely changed of it
                sure = {n: o for n, o in changes.items() if o.low > 0.0 or o.high < 0.0}
                changes = sure or changes
            what = _named_by(candidate.effect, changes)
            joints = (model.joints[candidate.joint],)
            torque = np.zeros((len(x), len(model.joints)))
            torque[:, candidate.joint] = candidate.columns(x) @ values
            made = Changed(what, joints, score.log_bf, step.p_value, changes, score.size)
            causes.append(Cause(made, torque))
    return _on_each_joint(_explaining(model, both, x, boundary, causes))


def changed_if_misfit(
    model: Model, motion: Motion, steps: int = MOST_STEPS, progress: Progress = silent
) -> tuple[Changed, ...] | None:
    """Return `changed_since` where the model errs clearly more than it promised, else None."""
    if not misfit_of(model, motion).larger:
        return None
    return changed_since(model, motion, steps, progress)


def _named_by(effect: Effect, changes: Mapping[str, Estimate]) -> str:
    """Return the name of what changed."""
    if not isinstance(effect, _Friction):
        return effect.name.removesuffix(SINCE)
    whose = {"F_c": "coulomb", "B": "viscous"}
    return " and ".join(whose[name] for name in changes)


def _explaining(
    model: Model, both: Motion, x: Inputs, boundary: float, causes: Sequence[Cause]
) -> Iterator[Cause]:
    """Yield the changes that lower the error of the model on the recording, with that error."""
    states = States(both.q, both.qd, both.qdd)
    later = both.time >= boundary
    predicted = both.tau.copy()
    new = both.take(np.flatnonzero(later))
    predicted[later] = model.predict(new.q, new.qd, new.qdd, time=new.time, segment=new.segment)
    known = (model.range.excess(states) <= OUTSIDE).all(axis=1) & later
    rows = x.index if x.index is not None else np.arange(len(x))
    seen, after_boundary = known[rows], later[rows]
    residual = x.mean(both.tau - predicted)
    for cause in causes:
        n = model.joints.index(cause.changed.joints[0])
        size = float(np.sqrt(np.mean(cause.torque[after_boundary, n] ** 2)))
        cause = replace(cause, changed=replace(cause.changed, size=size))
        if not seen.any():
            yield cause
            continue
        left = residual - cause.torque
        before, after = (float(np.sqrt(np.mean(one[seen, n] ** 2))) for one in (residual, left))
        if after < thresholds.USED.change_helps * before:
            residual = left
            made = replace(cause.changed, error_before=before, error_after=after)
            yield replace(cause, changed=made)


def _on_each_joint(causes: Iterator[Cause]) -> tuple[Changed, ...]:
    """Return the changes, those of one joint's friction as one."""
    found: dict[tuple[str, ...], Cause] = {}
    for cause in causes:
        one = cause.changed
        first_name = one.what.split(" and ")[0]
        kind = EFFECTS[first_name].kind if first_name in EFFECTS else ""
        key = ("friction", *one.joints) if kind == "friction" else (one.what, *one.joints)
        first = found.get(key)
        if first is None:
            found[key] = cause
            continue
        clash = {
            name: f"{one.what} {name}"
            for name in one.parameters
            if name in first.changed.parameters
        }
        more = {clash.get(name, name): value for name, value in one.parameters.items()}
        torque = first.torque + cause.torque
        acts = torque[np.any(torque != 0.0, axis=1)].sum(axis=1)
        joined = replace(
            first.changed,
            what=f"{first.changed.what} and {one.what}",
            log_bayes_factor=first.changed.log_bayes_factor + one.log_bayes_factor,
            parameters={**first.changed.parameters, **more},
            size=float(np.sqrt(np.mean(acts**2))),
            error_after=one.error_after,
        )
        found[key] = Cause(joined, torque)
    return tuple(one.changed for one in found.values())
