"""Waves of the residual over the joint's angle."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from where_examples import motion, noise, series

from lagrangian_ff.diagnosis.where import order_spectrum


@settings(max_examples=10)
@given(st.floats(12.0, 150.0), st.floats(0.0, 6.28), st.floats(0.05, 5.0))
def test_a_wave_is_found_with_its_order_and_amplitude(
    order: float, phase: float, size: float
) -> None:
    moved = motion(1)
    spectrum = order_spectrum(series(moved, size * np.cos(order * moved.q[:, 0] + phase)), 0)
    assert spectrum is not None
    assert spectrum.lines[0].order == pytest.approx(order, abs=0.15)
    assert spectrum.lines[0].amplitude == pytest.approx(size, rel=0.05)


def test_two_waves_under_noise_are_both_found() -> None:
    moved = motion(2)
    q = moved.q[:, 0]
    r = noise(len(moved), 0) + 0.5 * np.cos(20.0 * q) + 0.4 * np.sin(50.0 * q)
    spectrum = order_spectrum(series(moved, r), 0)
    assert spectrum is not None
    found = sorted(line.order for line in spectrum.lines[:2])
    assert found == pytest.approx([20.0, 50.0], abs=0.5)


def test_noise_has_hardly_ever_a_line() -> None:
    found = [
        order_spectrum(series(moved, noise(len(moved), seed)), 0, seed)
        for seed in range(20)
        if (moved := motion(seed))
    ]
    assert sum(bool(one.lines) for one in found if one is not None) <= 3
    below = [np.mean(one.amplitude <= one.noise) for one in found if one is not None]
    assert np.mean(below) == pytest.approx(0.95, abs=0.04)


def test_a_slow_dependence_on_position_is_no_line() -> None:
    moved = motion(3)
    spectrum = order_spectrum(series(moved, np.sin(1.5 * moved.q[:, 0])), 0)
    assert spectrum is not None
    assert all(line.amplitude < 0.2 for line in spectrum.lines)


def test_a_joint_that_hardly_moves_has_no_spectrum() -> None:
    moved = motion(4)
    still = replace(moved, q=1e-3 * moved.q)
    assert order_spectrum(series(still, noise(len(moved), 0)), 0) is None
    assert order_spectrum(series(moved, np.zeros(len(moved))), 0) is None
