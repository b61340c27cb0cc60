"""Models for the nodes: tried when loaded, and the same plan one state at a time."""

from pathlib import Path

import numpy as np
import pytest
from small_model import motion_at, save_small_model

from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model
from lagrangian_ff.nodes.common.models import OneStateModel, load_model
from lagrangian_ff.nodes.streaming.plan import Policy, make_plan
from lagrangian_ff.nodes.streaming.reference import Reference, RefusedReference


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "model.npz"
    save_small_model(path)
    return path


def test_columns_follow_the_joints_asked_for(file: Path) -> None:
    model, columns = load_model(str(file), ())
    assert model.joints == ("a", "b")
    assert columns.tolist() == [0, 1]
    assert load_model(str(file), ("b", "a"))[1].tolist() == [1, 0]


def test_a_real_model_gives_the_torques_it_predicts(file: Path) -> None:
    model, _ = load_model(str(file), ())
    time = np.linspace(0.0, 1.0, 30)
    q = np.column_stack([0.3 * time**2, -0.2 * time**2])
    qd, qdd = np.gradient(q, time, axis=0), np.full_like(q, 0.5)
    reference = Reference(model.joints, time, q, qd, qdd)
    plan = make_plan(model, reference, Policy("allow"))
    tau = plan.effort(np.ones(4), np.ones(2), np.full(2, 1e9))[plan.own]
    np.testing.assert_allclose(tau, model.predict(q, qd, qdd), atol=1e-9)


@pytest.mark.parametrize(
    ("joints", "expected"),
    [(("a", "c"), "a model of a, b, but parameter joints asks for a, c"), (("a",), "asks for a$")],
)
def test_other_joints_are_refused(file: Path, joints: tuple[str, ...], expected: str) -> None:
    with pytest.raises(ModelError, match=expected):
        load_model(str(file), joints)


def test_no_file_and_no_model_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="model_file is empty"):
        load_model("", ())
    with pytest.raises(ModelError, match="missing"):
        load_model(str(tmp_path / "missing.npz"), ())
    junk = tmp_path / "junk.npz"
    junk.write_bytes(b"junk")
    with pytest.raises(ModelError, match="junk"):
        load_model(str(junk), ())


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    return save_small_model(tmp_path_factory.mktemp("one_state") / "model.npz")


def setpoint(model: Model, at: float, scale: float = 1.0) -> Reference:
    q, qd, qdd = motion_at(np.array([at]))
    return Reference(model.joints, np.zeros(1), scale * q, qd, qdd)


def test_a_set_points_parts_are_those_of_the_model(model: Model) -> None:
    quick = OneStateModel(model)
    for at in (0.3, 1.7, 2.9):
        reference = setpoint(model, at)
        plan, whole = (make_plan(each, reference, Policy()) for each in (quick, model))
        np.testing.assert_allclose(plan.parts, whole.parts, atol=1e-9)
        total = model.predict(reference.q, reference.qd, reference.qdd)
        np.testing.assert_allclose(plan.parts.sum(axis=1), total, atol=1e-9)
        parts, weight = plan.at(12.3)
        np.testing.assert_array_equal(parts, plan.parts[0])
        assert weight == 1.0


def test_a_set_point_outside_fades_or_is_refused(model: Model) -> None:
    quick, outside = OneStateModel(model), setpoint(model, 0.3, 100.0)
    assert make_plan(quick, outside, Policy("fade")).weight == 0.0
    assert make_plan(quick, outside, Policy("allow")).weight == 1.0
    with pytest.raises(RefusedReference, match="position of"):
        make_plan(quick, outside, Policy("refuse"))
    inside = setpoint(model, 0.3)

    def doubts(*_: object) -> np.ndarray:
        return np.array([[0.1, 3.0]])

    doubted = make_plan(quick, inside, Policy("fade", doubt_limit=1.0), doubts=doubts)
    assert doubted.weight == 0.0
    assert "b is known to" in doubted.excess.worst
    np.testing.assert_array_equal(doubted.doubt, [0.1, 3.0])
