"""The low-pass and the derivatives on signals whose answers are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.recording.filtering import REACH, Butterworth, derivatives, settling

PERIOD = 0.002
TIME = PERIOD * np.arange(2000)
LOW_PASS = Butterworth(3, 25.0, 500.0)
INSIDE = slice(300, -300)


@given(st.lists(st.floats(-3, 3), min_size=1, max_size=8))
def test_derivatives_are_exact_on_polynomials_up_to_degree_seven(coefficients: list[float]) -> None:
    polynomial = np.polynomial.Polynomial(coefficients)
    time = np.linspace(-1, 1, 201)
    first, second = derivatives(polynomial(time), time[1] - time[0])
    inside = time[REACH:-REACH]
    assert np.allclose(first, polynomial.deriv()(inside), atol=1e-10)
    assert np.allclose(second, polynomial.deriv(2)(inside), atol=1e-7)


@given(st.lists(st.floats(-3, 3), min_size=1, max_size=6))
def test_the_filter_keeps_slow_polynomials(coefficients: list[float]) -> None:
    # |H|² = 1/(1 + (f/f0)^6) is flat to the fifth order at f = 0.
    polynomial = np.polynomial.Polynomial(coefficients)
    values = polynomial(TIME - 2)
    assert np.allclose(LOW_PASS.zero_phase(values, 100)[INSIDE], values[INSIDE], atol=1e-6)


@pytest.mark.parametrize("frequency", [0.5, 5.0, 25.0, 60.0])
def test_the_gain_is_the_square_of_the_filter_and_the_phase_zero(frequency: float) -> None:
    wave = np.sin(2 * np.pi * frequency * TIME)
    # The bilinear transform bends frequencies; at the bandwidth it is exact.
    ratio = np.tan(np.pi * frequency * PERIOD) / np.tan(np.pi * 25 * PERIOD)
    expected = wave / (1 + ratio**6)
    assert np.allclose(LOW_PASS.zero_phase(wave, 100)[INSIDE], expected[INSIDE], atol=1e-5)


def test_the_filter_has_settled_when_it_says_so() -> None:
    step = np.where(np.arange(2000) < 1000, 0.0, 1.0)
    filtered = LOW_PASS.zero_phase(step, 100)
    settled = 1000 + int(np.ceil(settling(3, 25.0) / PERIOD))
    assert np.abs(filtered[settled:] - 1).max() < 2e-3
    assert np.abs(filtered[settled - 20 :] - 1).max() > 2e-3
