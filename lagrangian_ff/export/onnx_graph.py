"""A torque as a graph of ONNX's operators: what of the state is added and multiplied."""

import ast
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects.curve import FADES
from lagrangian_ff.errors import ExportError
from lagrangian_ff.export import expressions
from lagrangian_ff.export.curves import PortableCurve
from lagrangian_ff.export.expressions import parsed
from lagrangian_ff.export.portable import Portable, PortableTerm
from lagrangian_ff.export.rigid import Form, LagrangianRbf, Motors, StateRbf, Trigonometric
from lagrangian_ff.kernels.structured.chain import LONG, SHORT

OPERATORS: Mapping[type[ast.operator], str] = {
    ast.Add: "Add", ast.Sub: "Sub", ast.Mult: "Mul", ast.Div: "Div", ast.Pow: "Pow",
}  # fmt: skip
FUNCTIONS = {name: name.capitalize() for name in expressions.FUNCTIONS}

DOUBLE = 11
"""ONNX's number for the type of doubles."""


class Graph:
    """Nodes that are added one by one; each method returns the name of what it computes."""

    def __init__(self) -> None:
        from onnx import helper, numpy_helper

        self._helper, self._numbers = helper, numpy_helper
        self.nodes: list[Any] = []
        self.constants: list[Any] = []
        self._held: dict[tuple[bytes, tuple[int, ...], str], str] = {}

    def constant(self, values: object) -> str:
        """Hold numbers; the same ones once."""
        array = np.asarray(values)
        key = array.tobytes(), array.shape, str(array.dtype)
        if key not in self._held:
            name = self._held[key] = f"constant_{len(self._held)}"
            self.constants.append(self._numbers.from_array(np.ascontiguousarray(array), name))
        return self._held[key]

    def op(self, kind: str, *inputs: object, **attributes: Any) -> str:
        """Add an operator; inputs are names, or numbers."""
        names = [one if isinstance(one, str) else self.constant(one) for one in inputs]
        out = f"value_{len(self.nodes)}"
        self.nodes.append(self._helper.make_node(kind, names, [out], **attributes))
        return out

    def column(self, values: str, joint: int) -> str:
        """Return (M, 1) of (M, N)."""
        return self.op("Gather", values, np.array([joint]), axis=1)

    def shaped(self, values: str, *size: int) -> str:
        """Return (M, *size)."""
        return self.op("Reshape", values, np.array([-1, *size]))

    def side_by_side(self, columns: list[str]) -> str:
        """Return (M, N) of N columns (M, 1)."""
        return self.op("Concat", *columns, axis=1)

    def last(self, values: str) -> str:
        """Return (M, 1) the last of (M, K)."""
        return self.op("Gather", values, np.array([-1]), axis=1)


def torque(graph: Graph, held: Portable, q: str, qd: str, qdd: str) -> str:
    """Add a model's torque of states (M, N), and return its name.

    Raises:
        ExportError: a form is not written in ONNX; says which and why.
    """
    joints = len(held.joints)
    rigid = graph.op("Mul", q, np.zeros(joints))
    for form in held.forms:
        if type(form) not in _FORMS:
            raise ExportError(
                f"the rigid-body part is a sum of the form '{form.kind}', whose loops have no "
                "operator in ONNX: export to c or json, or a model of chain, vrbfs or rbfs to onnx"
            )
        part = _FORMS[type(form)](graph, form, q, qd, qdd)
        rigid = graph.op("Add", rigid, graph.op("Mul", part, held.unit))
    states = {"q": q, "qd": qd, "qdd": qdd, "load": rigid, "torque": rigid}
    for term in held.terms:
        if term.constant:
            states["load"] = graph.op("Add", states["load"], _term(graph, term, states))
    total = states["load"]
    for term in held.terms:
        if not term.constant and not term.follows:
            total = graph.op("Add", total, _term(graph, term, states))
    for curve in held.curves:
        total = graph.op("Add", total, _curve(graph, curve, states, joints))
    states["torque"] = total
    for term in held.terms:
        if term.follows:
            total = graph.op("Add", total, _term(graph, term, states))
    return total


def _term(graph: Graph, term: PortableTerm, states: Mapping[str, str]) -> str:
    given = {name: graph.column(values, term.joint) for name, values in states.items()}
    for name, (what, joint) in term.others.items():
        given[name] = graph.column(states[what], joint)
    total = graph.op("Mul", given["q"], 0.0)
    for text, factor in zip(term.columns, term.coefficients, strict=True):
        column = _expression(graph, parsed(text), given, term.values)
        total = graph.op("Add", total, graph.op("Mul", column, np.float64(factor)))
    return graph.op("Mul", total, term.on)


def _curve(graph: Graph, curve: PortableCurve, states: Mapping[str, str], joints: int) -> str:
    """Return (M, N) the torque of a curve, as `c/curve.c`."""
    first, *second = (
        _splines(graph, graph.column(states[name], joint), knots)
        for (name, joint), knots in zip(curve.over, curve.knots(), strict=True)
    )
    found = graph.op("MatMul", first, curve.heights.reshape(len(curve.heights), -1))
    for other in second:
        found = graph.op("Mul", found, other)
        found = graph.op("ReduceSum", found, np.array([1]), keepdims=1)
    if curve.v0 is not None:
        speed = graph.op("Div", graph.column(states["qd"], curve.joint), np.float64(curve.v0))
        found = graph.op("Mul", found, graph.op("Tanh", speed))
    return graph.op("Mul", found, np.eye(joints)[curve.joint])


def _splines(graph: Graph, place: str, knots: Floats) -> str:
    """Return (M, K + 2) every B-spline at places (M, 1), times how far the curve has not faded.

    Those of degree 0 are 1 in one interval. Each degree mixes two of the degree before, of which
    at most four are not 0 (de Boor 1972, eq. (4)).
    """
    op, bends = graph.op, knots[3:-3]
    at = op("Min", op("Max", place, bends[0]), bends[-1])
    away = op("Div", op("Abs", op("Sub", place, at)), FADES * (bends[-1] - bends[0]))
    share = op("Max", op("Sub", 1.0, away), 0.0)
    fade = op("Mul", op("Mul", share, share), op("Sub", 3.0, op("Mul", share, 2.0)))
    never = np.full(3, np.inf)
    begin = np.concatenate([never, bends[:-1], never])
    end = np.concatenate([never, bends[1:-1], [np.inf], never])
    inside = op("And", op("GreaterOrEqual", at, begin), op("Less", at, end))
    found = op("Mul", op("Cast", inside, to=DOUBLE), fade)
    for degree in range(1, 4):
        count = len(knots) - degree - 1
        begin, end = knots[:count], knots[degree + 1 :]
        rising = op("Div", op("Sub", at, begin), knots[degree:-1] - begin)
        falling = op("Div", op("Sub", end, at), end - knots[1 : count + 1])
        lower, upper = (op("Gather", found, np.arange(count) + n, axis=1) for n in (0, 1))
        found = op("Add", op("Mul", rising, lower), op("Mul", falling, upper))
    return found


def _expression(
    graph: Graph, node: ast.expr, given: Mapping[str, str], values: Mapping[str, float]
) -> Any:
    """Return the name of an expression's value, or the number that it is."""
    if isinstance(node, ast.Constant):
        return np.float64(node.value)  # type: ignore[arg-type]
    if isinstance(node, ast.Name):
        return given[node.id] if node.id in given else np.float64(values[node.id])
    if isinstance(node, ast.UnaryOp):
        inner = _expression(graph, node.operand, given, values)
        return graph.op("Neg", inner) if isinstance(node.op, ast.USub) else inner
    if isinstance(node, ast.Call):
        assert isinstance(node.func, ast.Name)
        inputs = [_expression(graph, one, given, values) for one in node.args]
        return graph.op(FUNCTIONS[node.func.id], *inputs)
    assert isinstance(node, ast.BinOp)
    left, right = (_expression(graph, one, given, values) for one in (node.left, node.right))
    return graph.op(OPERATORS[type(node.op)], left, right)


def _trigonometric(graph: Graph, form: Trigonometric, q: str, qd: str, qdd: str) -> str:
    """As `c/trigonometric.c`, for all states at once."""
    joints = len(form.rotor)
    functions = [_functions(graph, graph.column(q, n)) for n in range(joints)]
    speed, hardness = ([graph.column(one, n) for n in range(joints)] for one in (qd, qdd))
    tau = [graph.op("Mul", hardness[n], np.float64(form.rotor[n])) for n in range(joints)]
    mass, rows = form.mass, 1

    def add(n: int, part: str, kind: str = "Add") -> None:
        tau[n] = graph.op(kind, tau[n], part)

    for k in range(joints):
        size = rows * LONG ** (joints - 1 - k)
        # The value, and by joint its slope.
        left: dict[int, str | Floats] = {-1: mass[:size]}
        mass = mass[size:]
        for n in range(joints - 1, k, -1):
            size //= LONG
            left = _without(graph, left, functions[n], n, LONG, size)
        for j in range(k, -1, -1):
            entry = {n: _last(graph, one) for n, one in left.items()}
            value = entry.pop(-1)
            share = graph.op("Mul", graph.op("Mul", speed[j], speed[k]), 0.5 if j == k else 1.0)
            rate = graph.op("Mul", speed[0], 0.0)
            for n, slope in entry.items():
                rate = graph.op("Add", rate, graph.op("Mul", slope, speed[n]))
                add(n, graph.op("Mul", share, slope), "Sub")
            for n, other in {(j, k), (k, j)}:
                add(n, graph.op("Mul", value, hardness[other]))
                add(n, graph.op("Mul", rate, speed[other]))
            if j > 0:
                size //= SHORT
                left = _without(graph, left, functions[j], j, SHORT, size)
        rows = SHORT * rows + 1
    left, size = {-1: form.potential}, form.potential.size
    for n in range(joints - 1, -1, -1):
        size //= SHORT
        left = _without(graph, left, functions[n], n, SHORT, size)
    for n in range(joints):
        add(n, str(left[n]))
    return graph.side_by_side(tau)


def _functions(graph: Graph, q: str) -> tuple[str, str]:
    """Return (M, 5) the functions of a joint and their slopes."""
    double = graph.op("Mul", q, 2.0)
    c, s, c2, s2 = (graph.op(kind, at) for at in (q, double) for kind in ("Cos", "Sin"))
    zero = graph.op("Mul", q, 0.0)
    value = graph.side_by_side([graph.op("Add", zero, 1.0), c, s, c2, s2])
    bent = [zero, graph.op("Neg", s), c, graph.op("Mul", s2, -2.0), graph.op("Mul", c2, 2.0)]
    return value, graph.side_by_side(bent)


def _without(
    graph: Graph,
    left: Mapping[int, "str | Floats"],
    functions: tuple[str, str],
    joint: int,
    count: int,
    size: int,
) -> dict[int, "str | Floats"]:
    """Return what is left without a joint, and the slope by it; see `take_joint` of the C file."""
    places = np.arange(count)
    value, slope = (graph.op("Gather", one, places, axis=1) for one in functions)

    def times(factors: str, array: "str | Floats") -> str:
        if not isinstance(array, str):
            return graph.op("MatMul", factors, array[: count * size].reshape(count, size))
        some = graph.op("Gather", array, np.arange(count * size), axis=1)
        product = graph.op(
            "MatMul", graph.shaped(factors, 1, count), graph.shaped(some, count, size)
        )
        return graph.shaped(product, size)

    found: dict[int, str | Floats] = {n: times(value, one) for n, one in left.items()}
    found[joint] = times(slope, left[-1])
    return found


def _last(graph: Graph, array: "str | Floats") -> str:
    if isinstance(array, str):
        return graph.last(array)
    return graph.constant(array[-1:].reshape(1, 1))


def _motors(graph: Graph, form: Motors, q: str, qd: str, qdd: str) -> str:
    return graph.op("Add", graph.op("Mul", qdd, form.inertia), graph.op("Mul", qd, form.viscous))


def _state_rbf(graph: Graph, form: StateRbf, q: str, qd: str, qdd: str) -> str:
    def apart(values: str, centres: Floats) -> str:
        """Return (M, C) squared distances."""
        gap = graph.op("Sub", graph.shaped(values, 1, centres.shape[1]), centres[None])
        return graph.op("ReduceSum", graph.op("Mul", gap, gap), np.array([2]), keepdims=0)

    place = apart(q, form.q)
    if form.angles:
        parts = [(graph.op("Cos", q), np.cos(form.q)), (graph.op("Sin", q), np.sin(form.q))]
        place = graph.op("Add", *(apart(*part) for part in parts))
    speed, hardness = apart(qd, form.qd), apart(qdd, form.qdd)
    columns = []
    for n in range(len(form.half)):
        rates = graph.op("Mul", speed, form.velocity_scale[n] ** 2)
        changes = graph.op("Mul", hardness, form.acceleration_scale[n] ** 2)
        distance = graph.op("Add", place, graph.op("Add", rates, changes))
        bell = graph.op("Exp", graph.op("Mul", distance, -form.half[n]))
        columns.append(graph.op("MatMul", bell, form.weights[:, [n]]))
    return graph.side_by_side(columns)


def _lagrangian_rbf(graph: Graph, form: LagrangianRbf, q: str, qd: str, qdd: str) -> str:
    """As `c/lagrangian_rbf.c`, for all states and centres at once."""
    op, joints = graph.op, len(form.w)
    at, v, a = (graph.shaped(one, 1, joints) for one in (q, qd, qdd))
    vu, au, b, w = form.qd[None], form.qdd[None], form.weights[None], form.w
    gap, turn = op("Sub", v, vu), op("Sub", at, form.q[None])
    e = op("Mul", gap, w)

    def total(values: str) -> str:
        return op("ReduceSum", values, np.array([2]), keepdims=1)

    if form.angles:
        p, r = (op("Mul", op(kind, turn), form.alpha) for kind in ("Sin", "Cos"))
        near = total(op("Sub", r, form.alpha))
    else:
        p = op("Mul", turn, form.alpha)
        r = op("Add", op("Mul", turn, 0.0), form.alpha)
        near = op("Mul", total(op("Mul", p, turn)), -0.5)
    k = op("Exp", op("Sub", near, op("Mul", total(op("Mul", e, gap)), 0.5)))
    xw = op("Mul", a, w)
    cx = total(op("Add", op("Mul", p, v), op("Mul", e, a)))
    cu = total(op("Add", op("Mul", p, vu), op("Mul", e, au)))
    rv = op("Mul", r, v)
    cxu = total(op("Add", op("Mul", rv, vu), op("Mul", xw, au)))
    ea, xa, ra = (total(op("Mul", one, b)) for one in (e, xw, rv))
    sa = total(op("Mul", op("Add", p, au * w), b))
    left = op("Sub", op("Mul", cu, ea), sa)
    of_e = op("Sub", op("Mul", cx, left), op("Mul", cxu, ea))
    of_e = op("Add", op("Sub", of_e, op("Mul", cu, xa)), ra)
    parts = (
        op("Mul", of_e, e),
        op("Mul", left, op("Sub", p, xw)),
        op("Mul", op("Sub", xa, op("Mul", cx, ea)), au * w),
        op("Mul", r, op("Sub", b, op("Mul", ea, vu))),
        op("Mul", op("Sub", cxu, op("Mul", cx, cu)), b * w),
    )
    summed = parts[0]
    for part in parts[1:]:
        summed = op("Add", summed, part)
    return op("ReduceSum", op("Mul", k, summed), np.array([1]), keepdims=0)


_FORMS: Mapping[type[Form], Callable[..., str]] = {
    Trigonometric: _trigonometric,
    Motors: _motors,
    StateRbf: _state_rbf,
    LagrangianRbf: _lagrangian_rbf,
}
"""The forms that ONNX holds."""
