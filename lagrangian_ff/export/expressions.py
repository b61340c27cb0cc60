"""Expressions of the state: read from text, evaluated, and written as C or text.

An expression holds numbers, names, + - * / ^, and the functions of `FUNCTIONS`. It is the one form
in which every format gets the effects.
"""

import ast
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np

from lagrangian_ff.effects.formula import SIGN
from lagrangian_ff.effects.inputs import SIGN_SPEED

FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "tanh": np.tanh, "atan": np.arctan,
    "exp": np.exp, "log": np.log, "sqrt": np.sqrt, "abs": np.abs,
    "min": np.minimum, "max": np.maximum,
}  # fmt: skip
"""What each function computes; `min` and `max` take two arguments, the others one."""
OPERATORS: Mapping[type[ast.operator], Callable[..., Any]] = {
    ast.Add: np.add, ast.Sub: np.subtract, ast.Mult: np.multiply, ast.Div: np.divide,
    ast.Pow: np.power,
}  # fmt: skip
SYMBOLS: Mapping[type[ast.operator], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/",
}  # fmt: skip
IN_C = {"abs": "fabs", "min": "fmin", "max": "fmax"}
SQUARE = 2.0


@cache
def parsed(text: str) -> ast.expr:
    """Return the tree of an expression, in which ^ is a power."""
    return ast.parse(text.replace("^", "**"), mode="eval").body


def text_of(node: ast.expr) -> str:
    """Return an expression as text; `parsed` reads it back."""
    return ast.unparse(node).replace("**", "^")


def names_in(node: ast.expr) -> set[str]:
    """Return the names that an expression depends on."""
    return {n.id for n in ast.walk(node) if isinstance(n, ast.Name)} - set(FUNCTIONS)


def evaluated(node: ast.expr, given: Mapping[str, Any]) -> Any:
    """Return the value of an expression, for values by name."""
    if isinstance(node, ast.Constant):
        return np.float64(node.value)  # type: ignore[arg-type]
    if isinstance(node, ast.Name):
        return given[node.id]
    if isinstance(node, ast.UnaryOp):
        return _signed(node.op) * evaluated(node.operand, given)
    if isinstance(node, ast.Call):
        assert isinstance(node.func, ast.Name)
        return FUNCTIONS[node.func.id](*(evaluated(one, given) for one in node.args))
    assert isinstance(node, ast.BinOp)
    left, right = evaluated(node.left, given), evaluated(node.right, given)
    return OPERATORS[type(node.op)](left, right)


def in_c(node: ast.expr, given: Mapping[str, str]) -> str:
    """Return an expression as C of the type `real`, for C expressions by name."""
    if isinstance(node, ast.Constant):
        return number_in_c(float(node.value))  # type: ignore[arg-type]
    if isinstance(node, ast.Name):
        return given[node.id]
    if isinstance(node, ast.UnaryOp):
        inner = in_c(node.operand, given)
        return f"(-{inner})" if isinstance(node.op, ast.USub) else inner
    if isinstance(node, ast.Call):
        assert isinstance(node.func, ast.Name)
        values = ", ".join(in_c(one, given) for one in node.args)
        return f"F({IN_C.get(node.func.id, node.func.id)})({values})"
    assert isinstance(node, ast.BinOp)
    left, right = in_c(node.left, given), in_c(node.right, given)
    if not isinstance(node.op, ast.Pow):
        return f"({left} {SYMBOLS[type(node.op)]} {right})"
    if isinstance(node.right, ast.Constant) and node.right.value == SQUARE:
        return f"square({left})"
    return f"F(pow)({left}, {right})"


def number_in_c(value: float) -> str:
    """Return a number as C that reads back to the same double."""
    return f"R({float(value)!r})" if value >= 0.0 else f"R(({float(value)!r}))"


def by_parameter(node: ast.expr, parameters: "frozenset[str]") -> dict[str, ast.expr]:
    """Return what each parameter multiplies in a torque that is linear in them.

    The formulas of users are read with `sign(qd)`, the smoothed sign of the joint, and `sign(x)` of
    all else, which is tanh(x / v0) of a fixed v0.
    """
    return {name: part for name, part in _parts(node, parameters).items() if name}


def _parts(node: ast.expr, parameters: "frozenset[str]") -> dict[str, ast.expr]:
    """Return the factors of parameters by name; "" for what has none."""
    one = ast.Constant(1.0)
    if isinstance(node, ast.Name):
        return {node.id: one} if node.id in parameters else {"": _named(node)}
    if isinstance(node, ast.Constant):
        return {"": node}
    if isinstance(node, ast.UnaryOp):
        inner = _parts(node.operand, parameters)
        return {name: ast.UnaryOp(node.op, part) for name, part in inner.items()}
    if isinstance(node, ast.Call):
        return {"": _called(node, parameters)}
    assert isinstance(node, ast.BinOp)
    left, right = _parts(node.left, parameters), _parts(node.right, parameters)
    if isinstance(node.op, ast.Add | ast.Sub):
        return _summed(node.op, left, right)
    if isinstance(node.op, ast.Mult) and set(left) <= {""}:
        return {name: ast.BinOp(left[""], node.op, part) for name, part in right.items()}
    return {name: ast.BinOp(part, node.op, right[""]) for name, part in left.items()}


def _summed(
    op: ast.operator, left: dict[str, ast.expr], right: dict[str, ast.expr]
) -> dict[str, ast.expr]:
    found = dict(left)
    for name, part in right.items():
        if name in left:
            found[name] = ast.BinOp(left[name], op, part)
        else:
            found[name] = ast.UnaryOp(ast.USub(), part) if isinstance(op, ast.Sub) else part
    return found


def _named(node: ast.Name) -> ast.expr:
    return ast.Constant(float(np.pi)) if node.id == "pi" else node


def _called(node: ast.Call, parameters: "frozenset[str]") -> ast.expr:
    assert isinstance(node.func, ast.Name)
    inner = _parts(node.args[0], parameters)[""]
    if ast.unparse(node) == SIGN:
        return ast.parse("tanh(qd / v0)", mode="eval").body
    if node.func.id == "sign":
        narrowed = ast.BinOp(inner, ast.Div(), ast.Constant(SIGN_SPEED))
        return ast.Call(ast.Name("tanh", ast.Load()), [narrowed], [])
    return ast.Call(node.func, [inner], [])


def _signed(op: ast.unaryop) -> float:
    return -1.0 if isinstance(op, ast.USub) else 1.0
