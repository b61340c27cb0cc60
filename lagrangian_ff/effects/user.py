"""Effects that users bring: from a Python file, or from an installed package.

A file defines subclasses of `Effect`; a package names them in its entry points of the group
`lagrangian_ff.effects`. They join `EFFECTS` and take part in everything.
"""

import importlib.util
import inspect
import sys
import traceback
import warnings
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType

from lagrangian_ff.effects.base import Effect
from lagrangian_ff.effects.catalogue import EFFECTS, GROUPS, effect_classes
from lagrangian_ff.effects.check import check
from lagrangian_ff.errors import EffectError
from lagrangian_ff.kernels import KERNELS

ENTRY_POINTS = "lagrangian_ff.effects"

_origin: dict[str, str] = {}
"""The file or package of each effect that users brought, by its name."""


def load_effects(path: "str | Path") -> list[Effect]:
    """Import a Python file and add the effects that it defines to `EFFECTS`.

    All of them join, or none. Loading a file again replaces what came from it.

    Raises:
        EffectError: the file does not import, defines no effect, or one that is not sound or has a
            name that is taken; names the file, the line, the effect, what was expected, what came.
    """
    file = Path(path)
    where = str(file)
    if not file.is_file():
        raise EffectError(f"{where}: no such file; expected Python that defines effects")
    found = _effects_of(_imported(file), where)
    if not found:
        raise EffectError(
            f"{where}: defines no effect; expected a class in it that derives from "
            "lagrangian_ff.effects.Effect and has name, formula, parameters and "
            "columns(self, x, joint, shape)"
        )
    _join(found, str(file.resolve()), where)
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
            effect = _made(entry.load(), where)
            _join([effect], where, where)
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
        spec.loader.exec_module(module)
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


def _join(effects: list[Effect], origin: str, where: str) -> None:
    """Check all effects, then add them to the catalogue."""
    taken = dict.fromkeys(EFFECTS, "the catalogue") | _origin
    taken = {name: place for name, place in taken.items() if place != origin}
    taken |= dict.fromkeys(GROUPS, "a group of effects")
    taken |= dict.fromkeys(KERNELS, "a kernel")
    for effect in effects:
        _check(effect, where)
        if effect.name in taken:
            raise EffectError(
                f"{where}: effect '{effect.name}': the name is taken by {taken[effect.name]}; "
                "choose another"
            )
        taken[effect.name] = where
    for name in [name for name, place in _origin.items() if place == origin]:
        del EFFECTS[name], _origin[name]
    for effect in effects:
        EFFECTS[effect.name] = effect
        _origin[effect.name] = origin


def _check(effect: Effect, where: str) -> None:
    try:
        check(effect)
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
