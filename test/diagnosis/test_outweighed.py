"""Outliers count less: noise is that of all other samples, and what they hid is found."""

from dataclasses import replace

import numpy as np
import pytest
import two_rods
from numpy.typing import NDArray
from whitened_examples import clean_rods, few_torques, whitened_of

from lagrangian_ff.diagnosis.search.forward import search
from lagrangian_ff.diagnosis.whitening import Whitened, counting_less, in_full, outweighed
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]


_small = few_torques(1000)


def stuck(motion: Motion) -> Motion:
    """Return a motion whose elbow sticks thirty times, for 50 ms."""
    rng = np.random.default_rng(5)
    tau = motion.tau.copy()
    for begin in rng.choice(len(motion) - 5, 30, replace=False):
        tau[begin : begin + 5, 1] += rng.choice([-1.0, 1.0]) * rng.uniform(1.5, 3.0)
    return replace(motion, tau=tau)


def drag(t: Floats, q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """Return a drag on the elbow of half the noise."""
    return np.stack([np.zeros_like(t), 0.012 * qd[:, 1] * np.abs(qd[:, 1])], axis=1)


def test_the_noise_of_a_joint_with_outliers_is_that_of_the_other_samples() -> None:
    clean, dirty = clean_rods(), whitened_of(stuck(two_rods.motion(1, 30.0)))
    assert dirty.noise[1] > 2.0 * clean.noise[1]
    light = outweighed(dirty)
    assert light is not None
    assert light.noise[1] < 1.3 * clean.noise[1]
    assert light.noise[0] == pytest.approx(clean.noise[0], rel=0.15)
    weight = light.problem.samples.weight
    assert weight is not None
    assert np.all(weight[:, 0] == 1.0)
    assert 0.01 < np.mean(weight[:, 1] < 0.5) < 0.3


def test_weights_are_kept_where_more_is_explained() -> None:
    light = outweighed(whitened_of(stuck(two_rods.motion(1, 30.0))))
    assert light is not None
    again = light.explaining(light.basis, light.problem.nuisance)
    np.testing.assert_array_equal(again.residual, light.residual)
    anew = light.assuming(light.problem)
    np.testing.assert_allclose(anew.residual, light.residual)


def test_in_full_outliers_are_noise_again() -> None:
    dirty = whitened_of(stuck(two_rods.motion(1, 30.0)))
    light = outweighed(dirty)
    assert light is not None
    again = in_full(light)
    assert again.problem.samples.weight is None
    np.testing.assert_allclose(again.noise, dirty.noise, rtol=0.2)
    assert in_full(dirty) is dirty


def test_a_motion_without_outliers_stays_as_it_is() -> None:
    clean = clean_rods()
    assert outweighed(clean) is None
    assert counting_less(clean) is clean


def test_the_search_finds_what_outliers_hide() -> None:
    def found(whitened: Whitened) -> list[tuple[str, int]]:
        return [step.score.candidate.key for step in search(whitened).steps]

    dirty = whitened_of(stuck(two_rods.motion(1, 40.0, drag)))
    assert ("quadratic_drag", 1) in found(dirty)
