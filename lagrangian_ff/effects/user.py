"""Effects that users bring, from a Python file or an installed package, and their check.

A file defines subclasses of `Effect`; a package names them in its entry points of the group
`lagrangian_ff.effects`. They join `EFFECTS` and take part in everything.
"""

import importlib.util
import inspect
import re
import sys
import traceback
import warnings
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType

import numpy as np

from lagrangian_ff.effects import base
from lagrangian_ff.effects.base import BROUGHT, Effect, Inputs, Origin
from lagrangian_ff.effects.catalogue import EFFECTS, GROUPS, effect_classes
from lagrangian_ff.effects.formula import Formula, read_formulas
from lagrangian_ff.effects.time_limit import in_time
from lagrangian_ff.errors import EffectError
from lagrangian_ff.kernels import KERNELS, States

ENTRY_POINTS = "lagrangian_ff.effects"
NAME = re.compile(r"[a-z][a-z0-9_]*")
WORDS = ("name", "formula", "source", "meaning", "coordinate", "shows_as", "next_motion", "caution")


def load_effects(path: str | Path) -> list[Effect]:
    """Import a Python file, or read formulas from JSON, and add the effects to `EFFECTS`.

    All of them join, or none. Loading a file again replaces what came from it.

    Raises:
        EffectError: the file does not import, defines no effect, or one that is not sound or has a
            name that is taken; names the file, the line, the effect, what was expected, what came.
    """
    file = Path(path)
    where = str(file)
    if not file.is_file():
        raise EffectError(f"{where}: no such file; expected Python that defines effects")
    formulas = file.suffix == ".json"
    found = read_formulas(file) if formulas else _effects_of(_imported(file), where)
    if not found:
        raise EffectError(
            f"{where}: defines no effect; expected a class in it that derives from "
            "lagrangian_ff.effects.Effect and has name, formula, parameters and "
            "columns(self, x, joint, shape)"
        )
    _join(found, Origin(str(file.resolve()), file), where)
    return found


@cache
def load_installed() -> tuple[Effect, ...]:
    """Add the effects of installed packages to `EFFECTS`, once.

    An effect that does not load or is not sound is left out with a warning.
    """
    loaded = []
    for entry in entry_points(group=ENTRY_POINTS):
        where = f"entry point {entry.name} = {entry.value}"
        try:
            effect = _made(in_time(where, entry.load), where)
            _join([effect], Origin(where), where)
        except (Exception, SystemExit) as error:
            said = error if isinstance(error, EffectError) else f"{where}: {_words(error)}"
            warnings.warn(f"an installed effect is left out: {said}", stacklevel=2)
            continue
        loaded.append(effect)
    return tuple(loaded)


def _imported(file: Path) -> ModuleType:
    name = f"_effects_of_users.{file.stem}"
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise EffectError(f"{file}: expected a Python file, with a name that ends in .py")
    module = importlib.util.module_from_spec(spec)
    # As dataclasses look their module up there; and no folder of byte code beside the user's file.
    sys.modules[name] = module
    written, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    try:
        loader = spec.loader
        in_time(f"{file}: importing it", lambda: loader.exec_module(module), file)
    except EffectError:
        del sys.modules[name]
        raise
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise EffectError(
            f"{file}: does not import: {_place(error, file)}{_words(error)}"
        ) from error
    finally:
        sys.dont_write_bytecode = written
    return module


def _effects_of(module: ModuleType, where: str) -> list[Effect]:
    """Return the instances, and one of each class that has none, without helpers with _."""
    public = [value for name, value in vars(module).items() if not name.startswith("_")]
    ours = list(EFFECTS.values())
    instances = [v for v in public if isinstance(v, Effect) and not any(v is o for o in ours)]
    made = {type(value) for value in instances}
    classes = [found for found in effect_classes(module) if found not in made]
    return [*instances, *(_made(found, where) for found in classes)]


def _made(found: object, where: str) -> Effect:
    """Return the effect, from a class or an instance."""
    if inspect.isclass(found) and issubclass(found, Effect):
        missing = sorted(found.__abstractmethods__)
        if missing:
            raise EffectError(f"{where}: effect {found.__name__} has no {', '.join(missing)}()")
        found = found()
    if not isinstance(found, Effect):
        raise EffectError(f"{where}: expected an Effect, got {type(found).__name__}")
    return found


def _join(effects: list[Effect], origin: Origin, where: str) -> None:
    """Check all effects, then add them to the catalogue."""
    taken = {name: BROUGHT[name].name if name in BROUGHT else "the catalogue" for name in EFFECTS}
    taken = {name: place for name, place in taken.items() if place != origin.name}
    taken |= dict.fromkeys(GROUPS, "a group of effects")
    taken |= dict.fromkeys(KERNELS, "a kernel")
    for effect in effects:
        _check(effect, where, origin.file)
        if effect.name in taken:
            raise EffectError(
                f"{where}: effect '{effect.name}': the name is taken by {taken[effect.name]}; "
                "choose another"
            )
        taken[effect.name] = where
    for name in [name for name in EFFECTS if BROUGHT.get(name) == origin]:
        del EFFECTS[name]
    for effect in effects:
        EFFECTS[effect.name] = effect
        BROUGHT[effect.name] = origin


def _check(effect: Effect, where: str, file: Path | None) -> None:
    try:
        in_time(f"effect '{effect.name}' on a trial motion", lambda: check(effect), file)
    except EffectError as error:
        raise EffectError(f"{where}: {error}") from error
    except Exception as error:
        raise EffectError(
            f"{where}: effect '{effect.name}' fails on a trial motion: "
            f"{_place(error, Path(where))}{_words(error)}"
        ) from error


def _place(error: BaseException, file: Path) -> str:
    """Return the line of the file at which it happened, for the beginning of a sentence."""
    if isinstance(error, SyntaxError) and error.lineno is not None:
        return f"line {error.lineno}: "
    frames = traceback.extract_tb(error.__traceback__)
    whole = file.resolve()
    lines = [frame.lineno for frame in frames if Path(frame.filename).resolve() == whole]
    return f"line {lines[-1]}: " if lines else ""


def _words(error: BaseException) -> str:
    said = error.msg if isinstance(error, SyntaxError) else str(error)
    return f"{type(error).__name__}: {said}" if said else type(error).__name__


def check(effect: Effect) -> None:
    """Refuse an effect that is not sound.

    Raises:
        EffectError: says what was expected and what is there, not in which file.
        Exception: whatever its `columns` or `candidates` raise on a trial motion.
    """
    _check_words(effect)
    _check_numbers(effect)
    moving = trial_motion(effect.last + 1 if isinstance(effect, Formula) else 0)
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


def _check_words(effect: Effect) -> None:
    for word in WORDS:
        if not isinstance(getattr(effect, word, None), str):
            _refuse(effect, word, "a text", getattr(effect, word, None))
    if not NAME.fullmatch(effect.name):
        _refuse(effect, "name", "one word of small letters, digits and _", effect.name)
    if not effect.formula:
        _refuse(effect, "formula", "the torque it adds, in words of its parameters", "")
    for word, allowed in (("kind", base.KINDS), ("part", base.PARTS), ("motion", base.MOTIONS)):
        if getattr(effect, word) not in allowed:
            _refuse(effect, word, f"one of {', '.join(allowed)}", getattr(effect, word))
    if not set(effect.uses) <= {"load", "torque"}:
        _refuse(effect, "uses", "a set of 'load' and 'torque'", effect.uses)


def _check_numbers(effect: Effect) -> None:
    parameters = getattr(effect, "parameters", None)
    if not parameters or not _all(parameters, base.Parameter):
        _refuse(effect, "parameters", "a tuple (Parameter(name, unit, meaning),)", parameters)
    if not _all(effect.shapes, base.Shape):
        expected = "a tuple (Shape(name, unit, meaning, low, high, start),)"
        _refuse(effect, "shapes", expected, effect.shapes)
    shapes: Sequence[base.Shape] = effect.shapes
    for shape in shapes:
        at_zero = shape.low <= 0.0 and not shape.whole and not shape.even
        if not shape.low <= shape.start <= shape.high or at_zero:
            came = f"{shape.low}, {shape.start}, {shape.high}"
            expected = "0 < low <= start <= high (or even=True)"
            _refuse(effect, f"shape {shape.name}", expected, came)
    numbers = [p.name for p in effect.parameters] + [s.name for s in shapes]
    if len(set(numbers)) < len(numbers):
        _refuse(effect, "parameters and shapes", "different names", ", ".join(numbers))


def _all(values: object, kind: type) -> bool:
    return isinstance(values, tuple | list) and all(isinstance(value, kind) for value in values)


def _refuse(effect: Effect, what: str, expected: str, came: object) -> None:
    name = getattr(effect, "name", type(effect).__name__)
    raise EffectError(f"effect '{name}': expected {what} to be {expected}, got {came!r}")


def trial_motion(joints: int = 0) -> Inputs:
    """Return joints that stand still first, then swing for 10 s, carry a load and warm up.

    Args:
        joints: how many at least; never fewer than three.
    """
    count = max(3, joints)
    time = np.arange(1000) / 100.0
    q = np.sin(np.maximum(time - 0.2, 0.0)[:, None] * np.linspace(2.0, 6.0, count))
    qd = np.gradient(q, time, axis=0)
    qdd = np.gradient(qd, time, axis=0)
    qd[:10] = qdd[:10] = 0.0
    load = 2.0 * qdd + 10.0 * np.cos(q)
    warm = 20.0 + time[:, None] * np.ones(count)
    states = States.of(q, qd, qdd)
    return Inputs.of(states, time=time, load=load, torque=load + qd, temperature=warm)
