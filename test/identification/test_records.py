"""The findings of an identification: where a mass matrix is positive definite, and their JSON."""

import json
from dataclasses import replace

import numpy as np
import pendulum
import pytest
from pendulum_models import fitted

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.findings import mass_check
from lagrangian_ff.identification.records import NEEDED, Identified


@pytest.fixture(scope="module")
def model() -> Model:
    """Return a good model of the pendulum."""
    return fitted("chain+fri").model


def lighter(model: Model, joint: int, inertia: float) -> Model:
    """Return the model with a rotor taken away from a joint."""
    term = Term(EFFECTS["rotor_inertia"], joint, {})
    coefficients = np.append(model.coefficients, -inertia)
    return replace(
        model,
        prior=replace(model.prior, basis=Basis((*model.basis.terms, term))),
        coefficients=coefficients,
    )


def test_a_good_one_is_positive_definite_all_along(model: Model) -> None:
    found = mass_check(model)
    assert model.identified.mass_matrix == found
    assert found.defined
    assert found.share == 0.0
    assert found.where == {}
    true = np.linalg.eigvalsh(pendulum.mass_matrix(model.data.q[model.trained]))
    assert found.least == pytest.approx(true.min(), rel=0.1)
    assert found.joint == "elbow"
    assert "positive definite all along the training motion" in found.words


def test_the_record_names_where_it_is_not_positive(model: Model) -> None:
    """Without most of the elbow's inertia it is not positive where the arm is stretched out."""
    found = mass_check(lighter(model, 1, 0.09))
    share, where = found.share, found.where
    q = model.data.q[model.trained]
    true = pendulum.mass_matrix(q)
    true[:, 1, 1] -= 0.09
    bad = np.linalg.eigvalsh(true)[:, 0] <= 0.0
    assert share == pytest.approx(bad.mean(), abs=0.05)
    assert where["elbow"] == pytest.approx([q[bad, 1].min(), q[bad, 1].max()], abs=0.3)
    assert found.joint == "elbow"
    low, high = where["elbow"]
    assert f"not positive definite on {100 * share:.0f} % of the training motion" in found.words
    assert f"where elbow is from {low:.2f} to {high:.2f} rad" in found.words


def test_where_it_is_so_everywhere_no_range_is_named(model: Model) -> None:
    found = mass_check(lighter(model, 0, 3.0))
    assert found.share == 1.0
    assert found.joint == "shoulder"
    assert "on 100 % of the training motion" in found.words
    assert "all over it" in found.words


@pytest.mark.parametrize(("name", "per_joint"), [("srbfs+fri", False), ("chain+fri", True)])
def test_there_is_none_where_joints_share_no_lagrangian(name: str, per_joint: bool) -> None:
    made = fitted(name, samples=30, per_joint=per_joint)
    stored, found = made.record["mass_matrix"], made.model.identified.mass_matrix
    assert stored == {"defined": False, "words": found.words}
    assert not found.defined
    assert "share no Lagrangian" in found.words


def test_the_findings_are_those_of_their_json(model: Model) -> None:
    found = model.identified
    again = Identified.from_record(json.loads(json.dumps(model.record)))
    assert json.dumps(again.record()) == json.dumps(found.record()) == json.dumps(model.record)
    assert again.score.joints == model.joints
    assert again.score.total == found.score.total == model.record["rmse"]
    assert again.effects == found.effects
    assert {one.joint for one in again.effects} == set(model.joints)
    assert not again.missing


def test_a_record_of_an_older_version_may_lack_anything() -> None:
    found = Identified.from_record({"model": "m", "settings": {"train": 0.5, "of_later": 1}})
    assert set(found.missing) == {*NEEDED} - {"model"}
    assert found.settings.train == 0.5
    for nothing in (found.effects, found.conditioning, found.outliers, found.sources):
        assert not nothing
    assert np.isnan([found.score.total, found.score.mean_nmse]).all()
