"""One state at a time, as a control loop asks: the torques of `Model.predict`."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pendulum
import pytest
from pendulum_models import fitted

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.identification.pointwise import Pointwise
from lagrangian_ff.kernels import KERNELS

FURTHER = (Term(EFFECTS["ripple"], 1, {"order": 3.0}), Term(EFFECTS["stribeck"], 0, {"v_s": 0.2}))
LOADED = (*FURTHER, Term(EFFECTS["load_friction"], 0, {}))
X = pendulum.states(3.0, 2.0, seed=5)[1]


@pytest.mark.parametrize(
    ("name", "further", "settings"),
    [
        *((name, FURTHER, {}) for name in KERNELS),
        ("chain", LOADED, {}),
        ("chain", FURTHER, {"landmarks": 30}),
        ("srbf", LOADED, {"landmarks": 30}),
        ("vrbfs", FURTHER, {"landmarks": 30, "positive": True}),
    ],
)
def test_it_is_the_torque_of_the_model(
    name: str, further: tuple[Term, ...], settings: Mapping[str, Any]
) -> None:
    model = fitted(f"{name}+fri", further=further, samples=40, noise=1e-2, **settings).model
    at = Pointwise(model)
    for i in range(len(X)):
        state = X.q[i], X.qd[i], X.qdd[i]
        np.testing.assert_allclose(at.torque(*state), model.predict(*state), rtol=1e-9)
        parts, expected = at.terms(*state), model.terms(*state)
        for name in ("gravity", "inertia", "coriolis"):
            np.testing.assert_allclose(
                getattr(parts, name), getattr(expected, name), rtol=1e-9, atol=1e-9
            )
        assert set(parts.effects) == set(expected.effects)
        for name, torque in expected.effects.items():
            np.testing.assert_allclose(parts.effects[name], torque, rtol=1e-9, atol=1e-12)
