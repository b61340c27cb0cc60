"""What hardware and nature allow of an effect's parameters."""

from dataclasses import replace

import numpy as np
import pytest
from effect_examples import motion, shapes_of

from lagrangian_ff.effects import EFFECTS, Inputs

BY_ANY_SIGN = {
    "asymmetric_coulomb", "asymmetric_viscous", "asymmetric_step", "position_friction",
    "temperature_friction",
}  # fmt: skip
"""Friction that brakes together with the rest of its joint only."""


@pytest.fixture(scope="module")
def x() -> Inputs:
    """Return a motion of three joints."""
    return motion()


def test_what_hardware_cannot_do_is_not_possible() -> None:
    """A gear gives way under all of its load, not a tenth of it."""
    for name in ("elasticity", "backlash"):
        assert EFFECTS[name].possible(np.array([1.1, -0.3]))
        assert not EFFECTS[name].possible(np.array([0.1, 0.5]))
        assert not EFFECTS[name].possible(np.array([-0.12, 0.5]))


@pytest.mark.parametrize("name", sorted(EFFECTS))
def test_what_nature_has_above_zero_is_above_zero_for_the_true_sign(name: str, x: Inputs) -> None:
    """Each positive parameter has its share in what decides."""
    effect = EFFECTS[name]
    shape = shapes_of(effect, x, 1)[0]
    positive = np.array([one.positive for one in effect.parameters])
    for weights in effect.signs(x, 1, shape).values():
        assert (weights[positive] > 0.0).all()
    if effect.part == "friction" and name not in BY_ANY_SIGN:
        assert effect.signs(x, 1, shape)


def test_stiffness_is_the_slope_over_the_range_that_was_visited(x: Inputs) -> None:
    far = replace(x, q=x.q + 3.0)
    (slope,) = EFFECTS["spring"].signs(far, 1, {}).values()
    softening = np.array([-10.0, 0.5])  # pushes about zero, pulls where the joint is
    line = np.polyfit(far.q[:, 1], EFFECTS["spring"].columns(far, 1, {}) @ softening, 1)
    assert slope @ softening == pytest.approx(line[0])
    assert line[0] > 0.0
