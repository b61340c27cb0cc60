"""What a change is worth, from the factor of what came before it."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import two_rods
from ground_examples import ground_of, quickly

from lagrangian_ff.diagnosis.ground import Changing, Ground
from lagrangian_ff.diagnosis.ground.ground import factored


@pytest.fixture(autouse=True, scope="module")
def _small() -> Iterator[None]:
    with quickly(800):
        yield


@pytest.fixture(scope="module")
def ground() -> Ground:
    """Return the ground of a motion in which nothing is hidden."""
    return ground_of(two_rods.motion(1))


@pytest.mark.parametrize("since", [0.0, 0.3, 0.7])
@pytest.mark.parametrize("until", [0.9, np.inf])
def test_a_change_is_worth_what_the_whole_matrix_says(
    ground: Ground, since: float, until: float
) -> None:
    time = ground.seen.time
    length = float(np.ptp(time))
    change = (float(time[0]) + since * length, float(time[0]) + until * length, 0.2)
    seen, tau = ground.seen, ground.seen.mean(ground.motion.tau)
    plain, changed = (
        factored(tau, seen, replace(ground.prior, change=one), ground.basis).log_evidence
        for one in (None, change)
    )
    gain = Changing.of(ground, len(ground.index)).gain(change)
    assert gain == pytest.approx(changed - plain, rel=1e-6, abs=1e-6)


def test_a_change_after_the_end_is_worth_nothing(ground: Ground) -> None:
    end = float(ground.seen.time[-1])
    assert Changing.of(ground, 100).gain((end + 1.0, np.inf, 0.2)) == 0.0
