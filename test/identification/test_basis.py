"""A basis of effects: what each one is given."""

import numpy as np

from lagrangian_ff.effects import EFFECTS, Inputs
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.kernels import States


def inputs(samples: int = 50) -> Inputs:
    rng = np.random.default_rng(0)
    x = Inputs.of(States.of(*rng.normal(size=(3, samples, 1))))
    load = rng.normal(size=(samples, 1))
    return Inputs(**{**vars(x), "load": load, "torque": load})


def test_a_limit_is_that_of_the_torque_before_it() -> None:
    """The torque that is clipped already plays no part, nor do other effects that follow it."""
    x = inputs()
    viscous = Term(EFFECTS["viscous"], 0)
    clipped = Term(EFFECTS["saturation"], 0, {"L": 0.8})
    basis, b = Basis((viscous, clipped)), np.array([0.5, 1.0])
    asked = x.load + 0.5 * x.qd
    np.testing.assert_allclose(x.load + basis.beside_load(x, b), asked)
    parts = basis.torque(x, b)
    assert list(parts) == ["viscous", "saturation"]
    total = x.load + sum(parts.values())
    np.testing.assert_allclose(total, np.clip(asked, -0.8, 0.8), atol=1e-12)
