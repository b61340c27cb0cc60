"""The record of where a learned mass matrix is positive definite."""

from dataclasses import replace

import numpy as np
import pendulum
import pytest
from pendulum_models import fitted

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.records import mass_record


@pytest.fixture(scope="module")
def model() -> Model:
    """Return a good model of the pendulum."""
    return fitted("chain+fri").model


def lighter(model: Model, joint: int, inertia: float) -> Model:
    """Return the model with a rotor taken away from a joint."""
    term = Term(EFFECTS["rotor_inertia"], joint, {})
    coefficients = np.append(model.coefficients, -inertia)
    return replace(model, basis=Basis((*model.basis.terms, term)), coefficients=coefficients)


def test_a_good_one_is_positive_definite_all_along(model: Model) -> None:
    found = mass_record(model)
    assert model.record["mass_matrix"] == found
    assert found["defined"]
    assert found["share"] == 0.0
    assert found["where"] == {}
    true = np.linalg.eigvalsh(pendulum.mass_matrix(model.data.q[model.trained]))
    assert found["least"] == pytest.approx(true.min(), rel=0.1)
    assert found["joint"] == "elbow"
    assert "positive definite all along the training motion" in str(found["words"])


def test_the_record_names_where_it_is_not_positive(model: Model) -> None:
    """Without most of the elbow's inertia it is not positive where the arm is stretched out."""
    found = mass_record(lighter(model, 1, 0.09))
    share, where = found["share"], found["where"]
    assert isinstance(share, float)
    assert isinstance(where, dict)
    q = model.data.q[model.trained]
    true = pendulum.mass_matrix(q)
    true[:, 1, 1] -= 0.09
    bad = np.linalg.eigvalsh(true)[:, 0] <= 0.0
    assert share == pytest.approx(bad.mean(), abs=0.05)
    assert where["elbow"] == pytest.approx([q[bad, 1].min(), q[bad, 1].max()], abs=0.3)
    assert found["joint"] == "elbow"
    words = str(found["words"])
    assert f"not positive definite on {100 * share:.0f} % of the training motion" in words
    assert f"where elbow is from {where['elbow'][0]:.2f} to {where['elbow'][1]:.2f} rad" in words


def test_where_it_is_so_everywhere_no_range_is_named(model: Model) -> None:
    found = mass_record(lighter(model, 0, 3.0))
    assert found["share"] == 1.0
    assert found["joint"] == "shoulder"
    assert "on 100 % of the training motion" in str(found["words"])
    assert "all over it" in str(found["words"])


@pytest.mark.parametrize(("name", "per_joint"), [("srbfs+fri", False), ("chain+fri", True)])
def test_there_is_none_where_joints_share_no_lagrangian(name: str, per_joint: bool) -> None:
    found = fitted(name, samples=30, per_joint=per_joint).record["mass_matrix"]
    assert isinstance(found, dict)
    assert set(found) == {"defined", "words"}
    assert not found["defined"]
    assert "share no Lagrangian" in found["words"]
