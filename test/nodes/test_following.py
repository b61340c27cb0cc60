"""An arm may do its motion too early or too late; one that does something else is noticed."""

import numpy as np
import pytest

from lagrangian_ff.arrays import Floats
from lagrangian_ff.nodes.attached.following import EARLY, NEAR, Seen


def path(time: Floats | float) -> Floats:
    """Return two joints that swing, up to 1.4 rad/s, from rest."""
    at = np.maximum(np.asarray(time, dtype=np.float64), 0.0)
    return np.stack([0.9 - 0.9 * np.cos(1.5 * at), 0.3 * np.sin(at) ** 2], axis=-1)


def looked(ahead: float, looks: int) -> tuple[Seen, list[float]]:
    """Return the counts for an arm that is `ahead` by some s, and what each look says of that."""
    seen, told = Seen(), []
    for now in 0.5 * np.arange(1, looks + 1):
        q = path(now + ahead)
        told.append(seen.lead(np.abs(q - path(now + EARLY))))
        seen.follows(np.abs(q - path(now)))
    return seen, told


@pytest.mark.parametrize("ahead", [0.5, 0.3, 0.22, -0.2, -0.33])
def test_an_arm_that_is_ahead_or_behind_is_noticed_before_it_counts_as_astray(ahead: float) -> None:
    _, told = looked(ahead, 8)
    first = next(n for n, lead in enumerate(told, 1) if lead)
    seen, _ = looked(ahead, first - 1)
    assert seen.followed
    assert told[first - 1] == pytest.approx(ahead, abs=0.03)


def test_an_arm_on_its_motion_is_neither() -> None:
    seen, told = looked(0.01, 12)
    assert seen.followed
    assert not any(told)


def test_an_arm_that_stands_is_astray_and_not_ahead() -> None:
    seen, told = Seen(), []
    for now in 0.5 * np.arange(1, 5):
        told.append(seen.lead(np.abs(path(0.0) - path(now + EARLY))))
        seen.follows(np.abs(path(0.0) - path(now)))
    assert np.abs(path(0.0) - path(2.0)).max() > NEAR
    assert not seen.followed
    assert not any(told)
