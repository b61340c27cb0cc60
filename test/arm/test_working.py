"""Motions of an arm at work: within limits, smooth, and at rest as long as asked."""

import numpy as np
import pytest

from lagrangian_ff.arm import MOTIONS, ArmParameters, Trajectory, check_limits, working_motion
from lagrangian_ff.errors import ArmError

STEP = 2e-3  # s


def sampled(motion: Trajectory) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    count = round(motion.duration / STEP)
    return motion.sample(np.linspace(motion.time[0], motion.time[-1], count + 1))


@pytest.mark.parametrize("kind", MOTIONS)
def test_the_motion_is_of_the_length_and_rests_as_asked(kind: str) -> None:
    motion = working_motion(kind, 20.0, 0.3, 0.4, 3)
    check_limits(motion)
    assert motion.duration == pytest.approx(20.0, abs=6.0)
    q, qd, qdd = sampled(motion)
    still = np.abs(qd).max(axis=1) < 5e-3
    assert still.mean() == pytest.approx(0.3, abs=0.08)
    assert np.ptp(q, axis=0).min() > 0.2
    # Velocity is the derivative of position, acceleration that of velocity; no step in either.
    np.testing.assert_allclose(np.gradient(q, STEP, axis=0), qd, atol=2e-3)
    np.testing.assert_allclose(np.gradient(qd, STEP, axis=0), qdd, atol=1.0)
    np.testing.assert_allclose(qd[[0, -1]], 0.0, atol=1e-9)


@pytest.mark.parametrize("kind", MOTIONS)
def test_without_rests_it_does_not_pause(kind: str) -> None:
    _, qd, _ = sampled(working_motion(kind, 10.0, 0.0, 0.4, 5))
    assert (np.abs(qd).max(axis=1) < 5e-3).mean() < 0.08


def test_the_seed_alone_decides() -> None:
    first, same, other = (working_motion("point-to-point", 10.0, 0.2, 0.4, k) for k in (1, 1, 2))
    np.testing.assert_array_equal(first.q, same.q)
    assert len(first) != len(other) or not np.array_equal(first.q, other.q)


@pytest.mark.parametrize("kind", MOTIONS)
def test_a_higher_pace_is_faster(kind: str) -> None:
    slow, fast = (sampled(working_motion(kind, 15.0, 0.2, pace, 2))[1] for pace in (0.2, 0.5))
    assert 1.5 < np.sqrt(np.mean(fast**2) / np.mean(slow**2)) < 4.0


def test_moves_from_point_to_point_spare_some_joints() -> None:
    _, qd, _ = sampled(working_motion("point-to-point", 20.0, 0.2, 0.4, 4))
    still = np.abs(qd) < 5e-3
    assert still.all(axis=1).mean() + 0.05 < still.mean()


def test_an_unknown_kind_is_refused() -> None:
    with pytest.raises(ArmError, match=r"expected point-to-point, fourier, spline, got 'waltz'"):
        working_motion("waltz", 10.0, 0.2, 0.4, 0)


def test_an_arm_too_heavy_for_its_motors_finds_no_motion() -> None:
    heavy = ArmParameters(link_masses=(30.0,) * 6)
    with pytest.raises(ArmError, match="no admissible"):
        working_motion("point-to-point", 10.0, 0.2, 0.4, 0, heavy)
