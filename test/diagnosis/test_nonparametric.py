"""Curves find the coordinate of a torque that no effect fits."""

import numpy as np
import pytest
import two_rods
from numpy.typing import NDArray
from whitened_examples import SHORT, few_torques, inputs, whitened_of

from lagrangian_ff.diagnosis.search.forward import search
from lagrangian_ff.diagnosis.search.nonparametric import (
    ALTERNATIVES,
    Sinusoid,
    SplineProduct,
    sinusoids,
)
from lagrangian_ff.effects import Inputs
from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]


_small = few_torques(1000, SHORT)


def shaken(t: Floats, q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """A floor that swings at 4.3 Hz, whatever the arm does."""
    return np.stack([1.5 * np.sin(2 * np.pi * 4.3 * t + 1.0), np.zeros(len(t))], axis=1)


def hose(t: Floats, q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """Friction of the shoulder, set by how far both joints are turned against each other."""
    grip = 1.0 - np.cos(2.0 * (q[:, 0] - q[:, 1]))
    return np.stack([2.0 * grip * np.tanh(qd[:, 0] / two_rods.WIDTH), np.zeros(len(t))], axis=1)


def test_a_sinusoid_is_found_at_its_frequency_whatever_its_phase() -> None:
    time = np.arange(0.0, 30.0, 0.01)
    noise = np.random.default_rng(0).normal(size=(len(time), 2))
    left = noise + np.stack([0.5 * np.sin(2 * np.pi * 3.37 * time + 2.0), 0 * time], axis=1)
    found = sinusoids(time, left)
    assert found[0].frequency == pytest.approx(3.37, abs=0.01)
    assert "3.37 Hz" in found[0].coordinate
    assert sinusoids(time[:50], left[:50]) == []


def test_without_time_there_is_no_sinusoid() -> None:
    states = Inputs.of(States.of(*np.ones((3, 5, 2))))
    assert not Sinusoid("tone", "time", 4.0).columns(states, 0).any()


@pytest.mark.parametrize("make", ALTERNATIVES)
def test_curves_are_even_in_what_they_are_of(make: object) -> None:
    """Hat functions add up to one, or to the sign of the velocity."""
    x = inputs(two_rods.motion(1, 20.0))
    for curve in make(x, 0):  # type: ignore[operator]
        total = curve.columns(x, 0).sum(axis=1)
        friction = isinstance(curve, SplineProduct) or curve.friction
        np.testing.assert_allclose(total, x.sign(0) if friction else 1.0, atol=1e-9)


@pytest.mark.parametrize(
    ("hidden", "words"),
    [
        (shaken, "time, swinging at 4.30 Hz"),
        (hose, "its position and that of joint 1, changing sign with direction"),
    ],
)
def test_what_no_effect_explains_is_named_by_its_coordinate(
    hidden: two_rods.Hidden, words: str
) -> None:
    found = search(whitened_of(two_rods.motion(1, 40.0, hidden)), steps=2)
    first = found.steps[0].score.candidate
    assert not first.named
    assert first.joint == 0
    assert first.source.coordinate == words
