"""Exponentials side by side are those of the mathematics library."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.loops import loop


def of(x: np.ndarray) -> np.ndarray:
    """What is written for x."""
    out = np.empty_like(x)
    loop("exponentials")(x.size, x, out)
    return out


@given(st.lists(st.floats(-700.0, 0.0), min_size=1, max_size=70))
def test_they_are_exact_to_the_last_two_bits(values: list[float]) -> None:
    x = np.array(values)
    np.testing.assert_allclose(of(x), np.exp(x), rtol=4.5e-16, atol=0.0)


def test_what_is_next_to_nothing_stays_so() -> None:
    far = of(np.array([-701.0, -800.0, -1e6, -1e300, -np.inf]))
    assert ((far > 0.0) & (far < 1e-300)).all()


def test_nothing_is_made_of_what_is_no_number() -> None:
    assert np.isnan(of(np.array([np.nan]))).all()
