"""The exported JSON: its schema, and torques that are computed from it and nothing else."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from export_examples import apart, curves, model_of, shape_of, states
from scipy.interpolate import BSpline

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.export import Options, write
from lagrangian_ff.export.effects import CATALOGUE
from lagrangian_ff.export.expressions import FUNCTIONS
from lagrangian_ff.export.json_file import SCHEMA
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.kernels import KERNELS

NUDGE = 1e-30  # of a complex step: derivatives are exact


def read(model: Model, tmp_path: Path, *, settled: bool = False) -> dict[str, Any]:
    path = tmp_path / "arm.json"
    write(model, "json", path, Options(settled=settled))
    found = json.loads(path.read_text(encoding="utf-8"))
    assert isinstance(found, dict)
    return found


def lagrangian(form: Mapping[str, Any], q: Any, qd: Any) -> Any:
    """The Lagrangian of a `trigonometric` form at one state, as docs/export.md writes it."""
    joints = len(q)
    f = [np.array([1.0, np.cos(one), np.sin(one), np.cos(2 * one), np.sin(2 * one)]) for one in q]
    mass, rows, value = np.array(form["mass"]), 1, 0.0
    for k in range(joints):
        size = rows * 5 ** (joints - 1 - k)
        left, mass = mass[:size], mass[size:]
        for n in range(joints - 1, k, -1):
            left = f[n] @ left.reshape(5, -1)
        for j in range(k, -1, -1):
            value = value + (0.5 if j == k else 1.0) * left[-1] * qd[j] * qd[k]
            left = f[j][:3] @ left[:-1].reshape(3, -1)
        rows = 3 * rows + 1
    height = np.array(form["potential"])
    for n in range(joints - 1, -1, -1):
        height = f[n][:3] @ height.reshape(3, -1)
    return value - height[0] + 0.5 * np.sum(np.array(form["rotor"]) * qd**2)


def rigid(form: Mapping[str, Any], q: Any, qd: Any, qdd: Any) -> Any:
    """d/dt ∂L/∂qd − ∂L/∂q of one state: the mass matrix times qdd, and what velocity adds."""
    joints = len(q)
    unit = np.eye(joints)

    def momentum(at: Any, speed: Any) -> Any:  # L is quadratic in speed, up to V
        still = lagrangian(form, at, 0.0 * speed)

        def along(direction: Any) -> Any:
            return lagrangian(form, at, direction) - still

        return np.array([0.5 * (along(speed + one) - along(speed - one)) for one in unit])

    slope = np.array([lagrangian(form, q + 1j * NUDGE * one, qd).imag / NUDGE for one in unit])
    turning = momentum(q + 1j * NUDGE * qd, qd).imag / NUDGE
    return momentum(q, qdd) + turning - slope


def splined(curve: Mapping[str, Any], state: Mapping[str, Any]) -> float:
    """A curve of one state, by SciPy's B-splines."""
    heights, fade = np.array(curve["heights"]), 1.0
    for over, bends in zip(curve["over"], map(np.array, curve["bends"]), strict=True):
        at, beyond = state[over["state"]][over["joint"]], np.arange(1.0, 4.0)
        low, high = bends[0], bends[-1]
        below = low - beyond[::-1] * (bends[1] - low)
        knots = np.concatenate([below, bends, high + beyond * (high - bends[-2])])
        heights = BSpline(knots, heights, 3)(np.clip(at, low, high))
        away = max(low - at, at - high, 0.0) / (curve["fades"] * (high - low))
        left = max(1.0 - away, 0.0)
        fade *= left * left * (3.0 - 2.0 * left)
    sign = 1.0 if curve["v0"] is None else np.tanh(state["qd"][curve["joint"]] / curve["v0"])
    return float(heights) * fade * sign


def effects(document: Mapping[str, Any], q: Any, qd: Any, qdd: Any, bodies: Any) -> Any:
    """All effects of one state, by Python's own reading of their expressions."""
    load, joints = bodies.copy(), len(q)
    listed = document["effects"]
    functions = {"__builtins__": {}, **FUNCTIONS}

    def one(effect: Mapping[str, Any], torque: Any) -> Any:
        n = effect["joint"]
        names = {"q": q[n], "qd": qd[n], "qdd": qdd[n], "load": load[n], "torque": torque[n]}
        state = {"q": q, "qd": qd, "qdd": qdd, "load": load}
        names |= {name: state[what][k] for name, (what, k) in effect["others"].items()}
        columns = [
            eval(text.replace("^", "**"), functions, names | effect["values"])
            for text in effect["columns"]
        ]
        return np.array(effect["on"]) * np.dot(effect["coefficients"], columns)

    for effect in listed:
        if effect["constant"]:
            load = load + one(effect, load)
    total = bodies + sum((one(e, load) for e in listed if not e["follows"]), np.zeros(joints))
    for curve in document["curves"]:
        total[curve["joint"]] += splined(curve, {"q": q, "qd": qd, "qdd": qdd, "load": load})
    return total + sum((one(e, total) for e in listed if e["follows"]), np.zeros(joints)) - bodies


def torque(document: Mapping[str, Any], q: Any, qd: Any, qdd: Any) -> Any:
    unit = np.array(document["unit"])
    bodies = unit * sum(rigid(form, q, qd, qdd) for form in document["rigid"])
    return bodies + effects(document, q, qd, qdd, bodies)


def test_torques_follow_from_the_file_alone(tmp_path: Path) -> None:
    names = [name for name, one in CATALOGUE.items() if not one.refused]
    terms = [Term(EFFECTS[name], 1, shape_of(EFFECTS[name])) for name in names if name != "coupled"]
    terms.append(Term(EFFECTS["coupled"], 0, {"partner": 2.0, "ratio": -1.0}))
    model, x = model_of("chain+fri", further=[*terms, *curves()]), states(20, 3)
    document = read(model, tmp_path)
    found = np.array([torque(document, *row) for row in zip(x.q, x.qd, x.qdd, strict=True)])
    assert apart(found, model.predict(x.q, x.qd, x.qdd)) < 1e-12


def test_the_file_holds_states_to_check_an_evaluation_with(tmp_path: Path) -> None:
    document = read(model_of("chain+stribeck+fri", joints=4), tmp_path)
    check = [np.array(document["check"][name]) for name in ("q", "qd", "qdd", "tau")]
    found = np.array([torque(document, *row) for row in zip(*check[:3], strict=True)])
    assert apart(found, check[3]) < 1e-12


@pytest.mark.parametrize("name", KERNELS)
def test_the_file_of_every_kernel_follows_the_schema(name: str, tmp_path: Path) -> None:
    validator = pytest.importorskip("jsonschema", reason="jsonschema is not installed")
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    validator.Draft202012Validator.check_schema(schema)
    document = read(model_of(f"{name}+fri+drift", further=curves()), tmp_path, settled=True)
    validator.validate(document, schema)
    assert document["settled"]["drift"]
    wrongs: tuple[dict[str, Any], ...] = (
        {"version": 2},
        {"rigid": [{"kind": "other"}]},
        {"joints": []},
        {"more": 1},
    )
    for wrong in wrongs:
        with pytest.raises(validator.ValidationError):
            validator.validate({**document, **wrong}, schema)
