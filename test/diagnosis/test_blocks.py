"""Blocks are as long as the whitened residual remembers."""

from dataclasses import replace

import numpy as np
import pytest
from whitened_examples import clean_rods, few_torques

from lagrangian_ff.diagnosis.whitening import Whitened
from lagrangian_ff.diagnosis.whitening.blocks import (
    LONGEST,
    MEMORIES,
    SHORTEST,
    block_seconds,
    memory,
    shortest_seconds,
)
from lagrangian_ff.sampling import usual_step

_small = few_torques(1000)


def remembering(seconds: float, seed: int = 0) -> Whitened:
    """Return a motion whose residual is a first-order process with this time constant."""
    whitened = clean_rods()
    samples = len(whitened.index)
    keep = np.exp(-usual_step(whitened.x.time) / seconds) if seconds > 0.0 else 0.0
    random = np.random.default_rng(seed).normal(size=(samples, whitened.joints))
    noise = np.zeros_like(random)
    for k in range(samples):
        noise[k] = keep * noise[k - 1] + np.sqrt(1.0 - keep**2) * random[k]
    return replace(whitened, residual=noise.ravel())


@pytest.mark.parametrize("seconds", [0.2, 0.5])
def test_the_memory_is_the_integral_correlation_time(seconds: float) -> None:
    """That of a first-order process is twice its time constant; the joint that has most counts."""
    found = np.median([memory(remembering(seconds, seed)) for seed in range(9)])
    assert 1.2 * seconds < found < 3.0 * seconds


def test_white_noise_remembers_one_sample() -> None:
    whitened = remembering(0.0)
    assert memory(whitened) < 2.0 * usual_step(whitened.x.time)


def test_blocks_are_longer_where_more_is_remembered_and_never_too_long() -> None:
    short, middle, long = (remembering(seconds) for seconds in (0.0, 0.1, 3.0))
    assert SHORTEST <= shortest_seconds(short) < shortest_seconds(middle)
    assert shortest_seconds(middle) == pytest.approx(MEMORIES * memory(middle))
    assert shortest_seconds(long) == block_seconds(long) == LONGEST


def test_much_motion_affords_blocks_longer_than_needed() -> None:
    whitened = remembering(0.0)
    assert block_seconds(whitened) == pytest.approx(30.0 / 30, rel=0.1)
