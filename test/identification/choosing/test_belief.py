"""The prior of hyperparameters: its slope and curvature, and what it does not believe in."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.identification.choosing.belief import RARITY, Belief


@given(seed=st.integers(0, 9999))
def test_slope_and_information_are_its_derivatives(seed: int) -> None:
    rng = np.random.default_rng(seed)
    middle, point = rng.normal(size=(2, 4))
    belief = Belief(middle, np.array([1.0, 0.0, 1.0, 0.0]))
    step = 1e-4
    for n, e in enumerate(step * np.eye(4)):
        up, here, down = (belief.height(point + way * e) for way in (1.0, 0.0, -1.0))
        np.testing.assert_allclose(belief.slope(point)[n], (up - down) / (2 * step), rtol=1e-6)
        bend = (up - 2.0 * here + down) / step**2
        np.testing.assert_allclose(belief.information(point)[n], -bend, rtol=1e-4)


def test_a_torque_many_times_as_large_is_not_believed_in() -> None:
    """Another logarithm may go as far for a few nats; that of a variance may become small."""
    hundredfold = np.array([2.0 * np.log(100.0)])
    free, held = Belief(np.zeros(1)), Belief(np.zeros(1), np.ones(1))
    assert free.height(hundredfold) > -5.0
    assert held.height(hundredfold) < -99.0 * RARITY
    assert held.height(-hundredfold) > held.height(np.zeros(1)) - 5.0
