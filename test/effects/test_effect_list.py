"""What every effect of the shared list must be."""

import numpy as np
import pytest

from lagrangian_ff.effects import EFFECTS, GROUPS, Effect, Inputs
from lagrangian_ff.kernels import States


@pytest.fixture(params=sorted(EFFECTS))
def effect(request: pytest.FixtureRequest) -> Effect:
    """Return each effect."""
    return EFFECTS[request.param]


@pytest.fixture
def states() -> Inputs:
    """Return states of three joints, rest among them."""
    rng = np.random.default_rng(0)
    q, qd, qdd = rng.normal(size=(3, 20, 3))
    qd[0] = 0.0
    return Inputs.of(States.of(q, qd, qdd))


def shape_of(effect: Effect) -> dict[str, float]:
    return {shape.name: shape.start for shape in effect.shapes}


def test_there_is_one_finite_column_a_parameter(effect: Effect, states: Inputs) -> None:
    columns = effect.columns(states, 1, shape_of(effect))
    assert columns.shape == (20, len(effect.parameters))
    assert np.isfinite(columns).all()


def test_it_explains_itself(effect: Effect) -> None:
    assert effect.formula
    assert effect.source
    assert effect.meaning
    assert effect.parameters
    assert all(p.name and p.unit and p.meaning for p in effect.parameters)
    assert all(s.name and s.unit and s.meaning for s in effect.shapes)
    assert all(s.low <= s.start <= s.high for s in effect.shapes)


def test_groups_are_made_of_effects() -> None:
    assert all(name in EFFECTS for names in GROUPS.values() for name in names)
    assert not set(GROUPS) & set(EFFECTS)


def test_friction_basis_is_the_papers_kernel(states: Inputs) -> None:
    """Φ Φᵀ equals (51), with the velocity in both tanh as the text of the paper says."""
    width = 0.05
    columns = np.hstack([EFFECTS[name].columns(states, 2, {"v0": width}) for name in GROUPS["fri"]])
    v = states.qd[:, 2]
    step = np.tanh(v / width)
    np.testing.assert_allclose(columns @ columns.T, np.outer(v, v) + np.outer(step, step) + 1.0)
