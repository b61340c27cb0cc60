"""One state at a time gives the plan that the whole model gives."""

import numpy as np
import pytest
from small_model import motion_at, save_small_model

from lagrangian_ff.identification import Model
from lagrangian_ff.nodes.common.errors import RefusedReference
from lagrangian_ff.nodes.streaming.one_state import OneAtATime
from lagrangian_ff.nodes.streaming.plan import Policy, make_plan
from lagrangian_ff.nodes.streaming.reference import Reference


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    return save_small_model(tmp_path_factory.mktemp("one_state") / "model.npz")


def setpoint(model: Model, at: float, scale: float = 1.0) -> Reference:
    q, qd, qdd = motion_at(np.array([at]))
    return Reference(model.joints, np.zeros(1), scale * q, qd, qdd)


def test_a_set_points_parts_are_those_of_the_model(model: Model) -> None:
    quick = OneAtATime(model)
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
    quick, outside = OneAtATime(model), setpoint(model, 0.3, 100.0)
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
