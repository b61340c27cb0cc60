"""The causal low-pass: its gain, its delay, and derivatives that are those of its output."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from lagrangian_ff.nodes.watching.causal import CausalFilter

Floats = NDArray[np.float64]


def filtered(order: int, bandwidth: float, time: Floats, values: Floats) -> list[Floats]:
    """(M-1,) the output and its derivatives behind each sample but the first."""
    low_pass = CausalFilter(order, bandwidth)
    low_pass.start(values[:1])
    told = []
    for passed, value in zip(np.diff(time), values[1:], strict=True):
        low_pass.take(passed, np.array([value]))
        told.append(low_pass.output())
    return [np.concatenate(each) for each in zip(*told, strict=True)]


@pytest.mark.parametrize("order", [1, 2, 3, 4])
@pytest.mark.parametrize("frequency", [2.0, 10.0, 20.0])
def test_the_gain_is_that_of_forward_and_backward(order: int, frequency: float) -> None:
    time = np.arange(0.0, 2.0, 0.0005)
    y, yd, ydd = filtered(order, 10.0, time, np.sin(2.0 * np.pi * frequency * time))
    late = slice(len(time) // 2, None)
    amplitude = np.ptp(y[late]) / 2.0
    assert amplitude == pytest.approx(1.0 / (1.0 + (frequency / 10.0) ** (2 * order)), rel=0.01)
    speed = 2.0 * np.pi * frequency
    assert np.ptp(yd[late]) / 2.0 == pytest.approx(amplitude * speed, rel=0.01)
    # The second derivative of straight pieces through an order of 1 has steps.
    assert np.ptp(ydd[late]) / 2.0 == pytest.approx(amplitude * speed**2, rel=0.02)


@given(
    st.floats(-3.0, 3.0),
    st.floats(-2.0, 2.0),
    st.lists(st.floats(1e-4, 0.02), min_size=5, max_size=20),
)
def test_a_straight_line_comes_late_by_the_delay_however_it_is_sampled(
    begin: float, slope: float, steps: list[float]
) -> None:
    time = np.cumsum(np.resize(steps, 400 + int(1.0 / np.mean(steps))))
    low_pass = CausalFilter(3, 25.0)
    y, yd, ydd = filtered(3, 25.0, time, begin + slope * time)
    late = time[1:] > time[0] + 3.0 * low_pass.settled
    expected = begin + slope * (time[1:] - low_pass.delay)
    np.testing.assert_allclose(y[late], expected[late], atol=1e-5)
    np.testing.assert_allclose(yd[late], slope, atol=1e-3)
    np.testing.assert_allclose(ydd[late], 0.0, atol=0.2)


def test_a_constant_is_there_at_once() -> None:
    low_pass = CausalFilter(3, 25.0)
    low_pass.start(np.array([2.0, -1.0]))
    low_pass.take(0.002, np.array([2.0, -1.0]))
    y, yd, ydd = low_pass.output()
    np.testing.assert_allclose(y, [2.0, -1.0], rtol=1e-12)
    np.testing.assert_allclose([yd, ydd], 0.0, atol=1e-6)


def test_what_was_before_is_forgotten_when_it_has_settled() -> None:
    low_pass = CausalFilter(3, 25.0)
    low_pass.start(np.array([0.0]))
    elapsed = 0.0
    while elapsed < low_pass.settled:
        low_pass.take(0.002, np.array([1.0]))
        elapsed += 0.002
    assert low_pass.output()[0][0] == pytest.approx(1.0, abs=2e-3)
