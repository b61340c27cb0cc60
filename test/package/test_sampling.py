"""Sample rate and length of a motion with gaps."""

import numpy as np
import pytest

from lagrangian_ff.sampling import recorded_seconds, stretches, usual_step

TIME = np.array([0.0, 0.1, 0.2, 5.0, 5.1, 5.2, 5.3])
SEGMENT = np.array([0, 0, 0, 1, 1, 1, 1])


def test_a_gap_is_neither_a_step_nor_time_that_was_recorded() -> None:
    assert usual_step(TIME, SEGMENT) == pytest.approx(0.1)
    assert recorded_seconds(TIME, SEGMENT) == pytest.approx(0.5)


def test_the_usual_step_is_the_median() -> None:
    assert usual_step(np.array([0.0, 1.0, 2.0, 9.0])) == 1.0


def test_one_sample_has_no_step() -> None:
    assert usual_step(TIME[:1]) == usual_step(TIME[2:4], SEGMENT[2:4]) == 0.0
    assert recorded_seconds(TIME[:1], SEGMENT[:1]) == 0.0


def test_stretches_are_the_runs_of_one_segment() -> None:
    assert stretches(SEGMENT) == [(0, 3), (3, 7)]
    assert stretches(SEGMENT[:0]) == []
