"""The check of an effect that somebody else wrote: its words, its numbers, one trial."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lagrangian_ff.effects import base
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.errors import EffectError
from lagrangian_ff.kernels.states import States

NAME = re.compile(r"[a-z][a-z0-9_]*")
WORDS = ("name", "formula", "source", "meaning", "coordinate", "shows_as", "next_motion", "caution")
JOINTS = 3


def check(effect: base.Effect) -> None:
    """Refuse an effect that is not sound.

    Raises:
        EffectError: says what was expected and what is there, not in which file.
        Exception: whatever its `columns` or `candidates` raise on a trial motion.
    """
    _check_words(effect)
    _check_numbers(effect)
    _try(effect)


def _check_words(effect: base.Effect) -> None:
    for word in WORDS:
        if not isinstance(getattr(effect, word, None), str):
            _refuse(effect, word, "a text", getattr(effect, word, None))
    if not NAME.fullmatch(effect.name):
        _refuse(effect, "name", "one word of small letters, digits and _", effect.name)
    if not effect.formula:
        _refuse(effect, "formula", "the torque it adds, in words of its parameters", "")
    if effect.kind not in base.KINDS:
        _refuse(effect, "kind", f"one of {', '.join(base.KINDS)}", effect.kind)
    if effect.part not in base.PARTS:
        _refuse(effect, "part", f"one of {', '.join(base.PARTS)}", effect.part)
    if effect.motion not in base.MOTIONS:
        _refuse(effect, "motion", f"one of {', '.join(base.MOTIONS)}", effect.motion)
    if not set(effect.uses) <= {"load", "torque"}:
        _refuse(effect, "uses", "a set of 'load' and 'torque'", effect.uses)


def _check_numbers(effect: base.Effect) -> None:
    parameters = getattr(effect, "parameters", None)
    if not parameters or not _all(parameters, base.Parameter):
        _refuse(effect, "parameters", "a tuple (Parameter(name, unit, meaning),)", parameters)
    if not _all(effect.shapes, base.Shape):
        _refuse(effect, "shapes", "a tuple (Shape(name, unit, meaning, low, high, start),)",
                effect.shapes)  # fmt: skip
    shapes: Sequence[base.Shape] = effect.shapes
    for shape in shapes:
        if not shape.low <= shape.start <= shape.high or (shape.low <= 0.0 and not shape.whole):
            _refuse(effect, f"shape {shape.name}", "0 < low <= start <= high",
                    f"{shape.low}, {shape.start}, {shape.high}")  # fmt: skip
    numbers = [p.name for p in effect.parameters] + [s.name for s in shapes]
    if len(set(numbers)) < len(numbers):
        _refuse(effect, "parameters and shapes", "different names", ", ".join(numbers))


def _all(values: object, kind: type) -> bool:
    return isinstance(values, tuple | list) and all(isinstance(value, kind) for value in values)


def _refuse(effect: base.Effect, what: str, expected: str, came: object) -> None:
    name = getattr(effect, "name", type(effect).__name__)
    raise EffectError(f"effect '{name}': expected {what} to be {expected}, got {came!r}")


def _try(effect: base.Effect) -> None:
    moving = trial_motion()
    still = replace(moving, time=np.full(len(moving), np.inf), segment=np.arange(len(moving)))
    names = {shape.name for shape in effect.shapes}
    tried = [{shape.name: shape.start for shape in effect.shapes}]
    for shape in effect.candidates(moving, 1):
        if set(shape) != names:
            _refuse(effect, "candidates()", f"numbers for {sorted(names)}", sorted(shape))
        tried.append(dict(shape))
    for shape in (tried[0], tried[-1]):
        for x in (moving, still):
            base.checked_columns(effect, x, 1, shape)


def trial_motion() -> Inputs:
    """Return joints that stand still first, then swing for 10 s, and carry a load."""
    time = np.arange(1000) / 100.0
    q = np.sin(np.maximum(time - 0.2, 0.0)[:, None] * np.linspace(2.0, 6.0, JOINTS))
    qd = np.gradient(q, time, axis=0)
    qdd = np.gradient(qd, time, axis=0)
    qd[:10] = qdd[:10] = 0.0
    load = 2.0 * qdd + 10.0 * np.cos(q)
    return Inputs.of(States.of(q, qd, qdd), time=time, load=load, torque=load + qd)
