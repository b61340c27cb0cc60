"""The exported ONNX graph: the same torques, in ONNX's reference and in a runtime."""

from pathlib import Path

import numpy as np
import pytest
from export_examples import Floats, apart, curves, model_of, shape_of, states

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import ExportError
from lagrangian_ff.export import Options, write
from lagrangian_ff.export.effects import CATALOGUE
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.kernels import States

pytest.importorskip("onnx", reason="the package onnx is not installed")


def referred(path: Path, x: States) -> Floats:
    from onnx.reference import ReferenceEvaluator

    (found,) = ReferenceEvaluator(str(path)).run(None, {"q": x.q, "qd": x.qd, "qdd": x.qdd})
    return np.asarray(found)


def exported(model: Model, tmp_path: Path) -> Path:
    write(model, "onnx", tmp_path / "arm.onnx")
    return tmp_path / "arm.onnx"


@pytest.mark.parametrize(
    "name", ["chain+fri", "vrbf+fri", "vrbfs+fri", "rbf+fri", "rbfs+fri", "none+fri"]
)
def test_the_graph_computes_the_torques_of_python(name: str, tmp_path: Path) -> None:
    model, x = model_of(name, centres=12), states(40, 3)
    found = referred(exported(model, tmp_path), x)
    assert apart(found, model.predict(x.q, x.qd, x.qdd)) < 1e-12


def test_the_graph_has_every_effect_that_is_a_function_of_the_state(tmp_path: Path) -> None:
    names = [name for name, one in CATALOGUE.items() if not one.refused]
    terms = [Term(EFFECTS[name], 0, shape_of(EFFECTS[name])) for name in names]
    model, x = model_of("motor", further=terms), states(40, 3)
    found = referred(exported(model, tmp_path), x)
    assert apart(found, model.predict(x.q, x.qd, x.qdd)) < 1e-11  # see IN_MOTORS of the C test


@pytest.mark.parametrize("count", [1, 500])
def test_the_graph_has_curves_as_python_has_them(count: int, tmp_path: Path) -> None:
    """Within what was seen, beyond it, and where a curve has faded."""
    runtime = pytest.importorskip("onnxruntime", reason="onnxruntime is not installed")
    model, x = model_of("vrbfs+fri", further=curves(), centres=12), states(500, 3)
    path, expected = exported(model, tmp_path), model.predict(x.q, x.qd, x.qdd)
    some = x.take(slice(0, count))
    (found,) = runtime.InferenceSession(str(path)).run(
        None, {"q": some.q, "qd": some.qd, "qdd": some.qdd}
    )
    for torque in (found, referred(path, some)):
        scale = np.abs(expected).max(axis=0)
        assert np.max(np.abs(torque - expected[:count]) / scale) < 1e-12


def test_a_runtime_computes_the_default_model_of_six_joints(tmp_path: Path) -> None:
    runtime = pytest.importorskip("onnxruntime", reason="onnxruntime is not installed")
    model, x = model_of("chain+fri", joints=6), states(200, 6)
    session = runtime.InferenceSession(str(exported(model, tmp_path)))
    (found,) = session.run(None, {"q": x.q, "qd": x.qd, "qdd": x.qdd})
    assert apart(found, model.predict(x.q, x.qd, x.qdd)) < 1e-12
    one = x.take(slice(0, 1))
    (alone,) = session.run(None, {"q": one.q, "qd": one.qd, "qdd": one.qdd})
    np.testing.assert_allclose(alone, found[:1], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", ["chain_rbf", "srbfs", "energy", "pol"])
def test_what_has_no_operators_is_refused_with_the_reason(name: str, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="no operator in ONNX: export to c or json"):
        write(model_of(name), "onnx", tmp_path / "arm.onnx")
    drifting = [Term(EFFECTS["drift"], 0, {})]
    with pytest.raises(ExportError, match="drift"):
        write(model_of("chain", further=drifting), "onnx", tmp_path / "arm.onnx", Options())
