"""Effects that are written as a formula: parsed, never executed.

A formula is a sum of terms, each with a parameter as a factor: `A exp(-(q/w)^2) + B qd abs(qd)`
written `A*exp(-(q/w)^2) + B*qd*abs(qd)`. Inputs are those of the joint itself, and `q_2` is the
position of the second joint, counted from 1. Names that are no input and have a range are shapes,
which are searched; all others are parameters, which the torque is linear in.
"""

import ast
import json
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from lagrangian_ff import budget
from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.inputs import SIGN_SPEED, Inputs
from lagrangian_ff.errors import EffectError

LONGEST = 400  # characters
USUAL_STEPS, MOST_STEPS = 6, 400
INPUTS = {"q": "rad", "qd": "rad/s", "qdd": "rad/s²", "load": "N·m"}
SINCE = "since"
"""The input that is the time in s since the joint turned round."""
OVER = {"q": "position", SINCE: "since_reversal", "load": "load", "qdd": "acceleration",
        "qd": "velocity", "": "position"}  # fmt: skip
"""Coordinate over which a formula shows, by the first of these inputs that it has. Velocity is
last: mostly only its sign is there."""
OTHER = re.compile(r"(q|qd|qdd|load)_([1-9]\d{0,2})")
"""The inputs of other joints."""
SIGN = "sign(qd)"
"""The smoothed sign of the joint's own velocity, as wide as that of its Coulomb friction."""
Range = tuple[float, float] | tuple[float, float, int] | tuple[float, float, int, str]
"""The ends of what is searched for a number, how many values are tried first, `EVENLY` if so."""
EVENLY = "even"
"""Says that values are spread evenly, as a place's, not over the logarithm."""
CONSTANTS = {"pi": np.pi}
FUNCTIONS: dict[str, Callable[[Floats], Floats]] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "tanh": np.tanh, "atan": np.arctan,
    "exp": np.exp, "log": np.log, "sqrt": np.sqrt, "abs": np.abs,
    "sign": lambda x: np.tanh(x / SIGN_SPEED),
}  # fmt: skip
OPERATORS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: np.add, ast.Sub: np.subtract, ast.Mult: np.multiply, ast.Div: np.divide,
    ast.Pow: np.power,
}  # fmt: skip


@dataclass(frozen=True)
class Sum:
    """A torque that is linear in parameters.

    Attributes:
        parts: by parameter what it multiplies, (M,) or a number; "" for what has none.
    """

    parts: Mapping[str, Any]

    @property
    def plain(self) -> bool:
        """Return whether no parameter is in it."""
        return set(self.parts) <= {""}

    @property
    def value(self) -> Any:
        """Return what it is without parameters."""
        return self.parts.get("", 0.0)


class Formula(Effect):
    """A torque that a formula describes.

    Attributes:
        tree: the formula, parsed.
        inputs: its inputs: by name the attribute of the motion and the joint, None for its own.
        only: the one joint that it is tried on; None for all.
    """

    tree: ClassVar[ast.expr]
    inputs: ClassVar[Mapping[str, tuple[str, int | None]]]
    only: ClassVar[int | None] = None

    def __reduce__(self) -> tuple[Any, ...]:
        # A process, or a copy, makes it again: its class has no place to be found at.
        return formula_of, (self.stored(), self.only)

    def stored(self) -> dict[str, Any]:
        """Return the formula as JSON holds it, in a file of effects or in a model's."""
        units = {one.name: one.unit for one in self.parameters}
        units |= {one.name: one.unit for one in self.shapes}
        shapes = {
            one.name: [one.low, one.high, one.steps, *([EVENLY] if one.even else [])]
            for one in self.shapes
        }
        known = {"name": self.name, "formula": self.formula, "shapes": shapes}
        return {**known, "units": units, "meaning": self.meaning}

    @property
    def last(self) -> int:
        """Return the number of the last joint that it reads besides its own, from 1; 0 for none."""
        return max((of + 1 for _, of in self.inputs.values() if of is not None), default=0)

    def candidates(self, x: Inputs, joint: int) -> Sequence[Values]:
        """Return the shapes to try; none on a joint that it reads as another one."""
        others = {of for _, of in self.inputs.values()}
        if self.last > x.joints or joint in others or self.only not in (None, joint):
            return []
        return super().candidates(x, joint)

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        if self.last > x.joints:
            raise _error(self.name, f"it reads joint {self.last}; there are {x.joints} joints")
        given: dict[str, Any] = {
            name: x.since_reversal(joint) if what == SINCE else
            getattr(x, what)[:, joint if of is None else of]
            for name, (what, of) in self.inputs.items()
        }  # fmt: skip
        found = self.torque({**given, SIGN: x.sign(joint), **shape})
        parts = [found.parts.get(one.name, 0.0) for one in self.parameters]
        return np.column_stack([np.broadcast_to(np.asarray(one), len(x)) for one in parts])

    def torque(self, given: Mapping[str, Any]) -> Sum:
        """Return the torque for inputs and shapes by name."""
        with np.errstate(all="ignore"):
            return _evaluated(self.tree, {**CONSTANTS, **given}, self.name)


def formula_effect(
    name: str,
    formula: str,
    shapes: Mapping[str, Range],
    meaning: str = "",
    units: Mapping[str, str] | None = None,
    only: int | None = None,
) -> Formula:
    """Return an effect whose torque is a formula.

    Args:
        name: one word.
        formula: see above.
        shapes: the range of each number that is searched, by name.
        meaning: what it is, in a few words.
        units: of parameters and shapes, by name; SI if not given.
        only: the one joint that it is tried on, from 0; None for all.

    Raises:
        EffectError: the formula cannot be read, or is not linear in its parameters.
    """
    tree = _parsed(name, formula)
    names = _names(tree)
    inputs = {one: read for one in names if (read := _input(one)) is not None}
    unknown = [one for one in names if one not in {**inputs, **CONSTANTS}]
    units = units or {}
    for shape, (low, high, *more) in shapes.items():
        if shape not in unknown:
            raise _error(name, f"{shape} has a range and is not in the formula")
        if not -np.inf < low < high < np.inf or (low == 0.0 and more[1:] != [EVENLY]):
            expected = "0 < low < high, or low < 0 for a place"
            raise _error(name, f"{shape} has the range {low} to {high}, expected {expected}")
        if more[1:] not in ([], [""], [EVENLY]):
            raise _error(name, f"{shape}: expected '{EVENLY}' as fourth value, got {more[1]!r}")
    brakes = any(what in ("qd", SINCE) for what, _ in inputs.values())
    own = [one for one in unknown if one not in shapes]
    if not own:
        raise _error(name, "it has no parameter; write one before each term, as in A*sin(q)")
    content = {
        "name": name,
        "formula": formula,
        "tree": tree,
        "inputs": inputs,
        "only": only,
        "meaning": meaning or f"a formula of your own, {formula}",
        "source": "a formula of the user",
        "parameters": tuple(
            Parameter(one, units.get(one, "SI"), "a factor of the formula") for one in own
        ),
        "shapes": tuple(_shape(one, units.get(one, "SI"), *given) for one, given in shapes.items()),
        "uses": frozenset({"load"} & {what for what, _ in inputs.values()}),
        "remembers": SINCE in inputs,
        "coordinate": next(over for one, over in OVER.items() if one in names or not one),
        "kind": "friction" if brakes else "mechanics",
        "part": "friction" if brakes else "inertia" if "qdd" in inputs else "gravity",
    }
    effect: Formula = type("Formula", (Formula,), content)()
    still: dict[str, Any] = {**dict.fromkeys(inputs, np.ones(1)), SIGN: np.ones(1)}
    found = effect.torque({**still, **{one.name: one.start for one in effect.shapes}})
    if "" in found.parts and np.any(found.value != 0.0):
        raise _error(name, "a term has no parameter as a factor; the torque must be linear in them")
    return effect


def _input(name: str) -> tuple[str, int | None] | None:
    """Return what an input reads of the motion, and of which joint; None if it is no input."""
    match = OTHER.fullmatch(name)
    if match is not None:
        return match[1], int(match[2]) - 1
    return (name, None) if name in INPUTS or name == SINCE else None


def _shape(
    name: str, unit: str, low: float, high: float, steps: int = USUAL_STEPS, spread: str = ""
) -> Shape:
    even = spread == EVENLY or low < 0.0
    middle = 0.5 * (low + high) if even else float(np.sqrt(low * high))
    return Shape(name, unit, "a number of the formula", low, high, middle, steps, even=even)


def read_formulas(file: Path) -> list[Effect]:
    """Return the effects in a JSON file: a list `effects` of objects.

    Each has `name` and `formula`, and may have `shapes`, by name [low, high], [low, high, steps] or
    [low, high, steps, "even"], `units` by name, and `meaning`.

    Raises:
        EffectError: the file cannot be read, or holds something else.
    """
    try:
        listed = json.loads(budget.text_of(file, EffectError))["effects"]
        return [formula_of(one) for one in listed]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise EffectError(
            f'{file}: expected {{"effects": [{{"name": ..., "formula": ...}}]}}, got {error}'
        ) from error


def formula_of(record: Mapping[str, Any], only: int | None = None) -> Formula:
    """Return the effect that one object of such a file describes.

    Args:
        only: see `formula_effect`.

    Raises:
        EffectError: its formula cannot be read.
        TypeError, ValueError, AttributeError: it is of another form.
    """
    ranges = record.get("shapes", {})
    shapes = {str(name): _range(*given) for name, given in ranges.items()}
    units = {str(key): str(unit) for key, unit in record.get("units", {}).items()}
    name, formula, meaning = (str(record.get(key, "")) for key in ("name", "formula", "meaning"))
    return formula_effect(name, formula, shapes, meaning, units, only)


def _range(low: Any, high: Any, steps: Any = USUAL_STEPS, spread: Any = "") -> Range:
    """Return the range of a shape from JSON."""
    return float(low), float(high), int(np.clip(int(steps), 2, MOST_STEPS)), str(spread)


def _error(name: str, words: str) -> EffectError:
    return EffectError(f"effect '{name}': {words}")


def _parsed(name: str, formula: str) -> ast.expr:
    if not formula.strip() or len(formula) > LONGEST:
        raise _error(name, f"expected a formula of 1 to {LONGEST} characters")
    try:
        with warnings.catch_warnings():  # of Python, about its own syntax
            warnings.simplefilter("error", SyntaxWarning)
            tree = ast.parse(formula.strip().replace("^", "**"), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        where = f" at character {error.offset}" if isinstance(error, SyntaxError) else ""
        raise _error(name, f"{formula!r} is no formula{where}") from None
    for node in ast.walk(tree):
        if not _allowed(node):
            raise _error(
                name,
                f"{formula!r} holds {ast.unparse(node) if isinstance(node, ast.expr) else node!r}; "
                f"expected numbers, + - * / ^, {', '.join(INPUTS)}, {SINCE}, those of other "
                "joints as in q_2, names of your own and "
                f"{', '.join(FUNCTIONS)}",
            )
    return tree


def _allowed(node: ast.AST) -> bool:
    if isinstance(node, ast.Call):
        called = isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS
        return called and len(node.args) == 1 and not node.keywords
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int | float) and abs(node.value) < 1e12
    if isinstance(node, ast.Name):
        return node.id.isidentifier() and not node.id.startswith("_")
    kinds = (ast.BinOp, ast.UnaryOp, ast.USub, ast.UAdd, ast.Load, *OPERATORS)
    return isinstance(node, kinds)


def _names(tree: ast.expr) -> list[str]:
    """Return the names in the order in which they come, functions not."""
    called = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
    names = [n for n in ast.walk(tree) if isinstance(n, ast.Name) and id(n) not in called]
    names.sort(key=lambda node: (node.lineno, node.col_offset))
    return list(dict.fromkeys(node.id for node in names))


def _evaluated(node: ast.expr, given: Mapping[str, Any], name: str) -> Sum:
    if isinstance(node, ast.Constant):
        return Sum({"": float(node.value)})  # type: ignore[arg-type]
    if isinstance(node, ast.Name):
        return Sum({"": given[node.id]}) if node.id in given else Sum({node.id: 1.0})
    if isinstance(node, ast.UnaryOp):
        inner = _evaluated(node.operand, given, name)
        sign = -1.0 if isinstance(node.op, ast.USub) else 1.0
        return Sum({key: sign * value for key, value in inner.parts.items()})
    if isinstance(node, ast.Call):
        if ast.unparse(node) == SIGN and SIGN in given:
            return Sum({"": given[SIGN]})
        inner = _evaluated(node.args[0], given, name)
        assert isinstance(node.func, ast.Name)
        if not inner.plain:
            raise _nonlinear(name, inner)
        return Sum({"": FUNCTIONS[node.func.id](np.asarray(inner.value, dtype=np.float64))})
    assert isinstance(node, ast.BinOp)
    left, right = _evaluated(node.left, given, name), _evaluated(node.right, given, name)
    operate = OPERATORS[type(node.op)]
    if isinstance(node.op, ast.Add | ast.Sub):
        keys = dict.fromkeys([*left.parts, *right.parts])
        return Sum({k: operate(left.parts.get(k, 0.0), right.parts.get(k, 0.0)) for k in keys})
    if isinstance(node.op, ast.Mult) and left.plain:
        return Sum({key: operate(left.value, value) for key, value in right.parts.items()})
    if isinstance(node.op, ast.Mult | ast.Div) and right.plain:
        return Sum({key: operate(value, right.value) for key, value in left.parts.items()})
    if left.plain and right.plain:
        base = np.asarray(left.value, dtype=np.float64)
        return Sum({"": operate(base, np.asarray(right.value, dtype=np.float64))})
    raise _nonlinear(name, right if left.plain else left)


def _nonlinear(name: str, found: Sum) -> EffectError:
    of = ", ".join(key for key in found.parts if key)
    return _error(
        name, f"the torque is not linear in {of}; give {of} a range, so that it is searched"
    )
