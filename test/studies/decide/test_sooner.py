"""The time of designed motion until an error, over that of `exciting`."""

import numpy as np
import pytest

from lagrangian_ff.studies.decide.sooner import TIMES, ratio

EXCITING = [0.8, 0.6, 0.5, 0.4, 0.3, 0.25, 0.2]


@pytest.mark.parametrize(
    ("designed", "seconds"),
    [
        ([0.8, 0.4, 0.2, 0.2, 0.2, 0.2, 0.2], TIMES[2]),
        ([0.2] * 7, TIMES[0]),
        ([0.8, 0.4, 0.1, 0.1, 0.1, 0.1, 0.1], 0.5 * (TIMES[1] + TIMES[2])),
        ([0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.21], np.inf),
        ([0.8, 0.7, 0.4, 0.4, 0.1, 0.5, 0.5], 0.5 * (TIMES[3] + TIMES[4])),
    ],
)
def test_the_smallest_error_of_exciting_is_reached_between_two_times(
    designed: list[float], seconds: float
) -> None:
    found = ratio({"exciting": EXCITING, "designed": designed})
    assert found == pytest.approx(seconds / TIMES[-1])


def test_it_is_compared_with_when_exciting_was_best() -> None:
    usual = [0.8, 0.6, 0.2, 0.4, 0.3, 0.25, 0.3]
    assert ratio({"exciting": usual, "designed": usual}) == pytest.approx(1.0)
