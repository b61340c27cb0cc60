"""The bound of tracking comes from a process beside, and leaves none behind."""

from multiprocessing import active_children

import pytest

pytest.importorskip("pybullet")

from lagrangian_ff.arm import JOINTS, exciting_trajectory, simulate
from lagrangian_ff.demo.bound import bound_of


def test_the_bound_is_the_tracking_error_with_true_torques() -> None:
    trajectories = [exciting_trajectory(5, seed, 4.0) for seed in (0, 1)]
    with bound_of(trajectories, seed=3) as bound:
        found = bound()
    assert len(found) == 2
    for one, trajectory in zip(found, trajectories, strict=True):
        assert one.joints == JOINTS
        assert one.time[-1] == pytest.approx(trajectory.duration, abs=0.002)
        run = simulate(trajectory, seed=3)
        assert 0.0 < one.total < 0.1 * float((run.tracking_error**2).mean() ** 0.5)


def test_leaving_early_ends_the_process() -> None:
    before = set(active_children())
    with bound_of([exciting_trajectory(5, 0, 60.0)], seed=0):
        assert set(active_children()) - before
    assert not set(active_children()) - before
