"""Order, repeats, periods and resets of time stamps, and stamps that are late."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrangian_ff.recording import Conditioning, Recording, condition
from lagrangian_ff.recording.stamps import (
    clock_resets,
    order,
    retime,
    steady_clock,
    usual_period,
    without_resets,
)

CLEAN = 0.002 * np.arange(200, dtype=np.float64)


@given(st.permutations(range(40)), st.lists(st.integers(0, 39), max_size=10))
def test_order_recovers_a_shuffled_and_repeated_clock(
    shuffle: list[int], repeats: list[int]
) -> None:
    time = CLEAN[np.array([*shuffle, *repeats])]
    found = order(time)
    assert np.array_equal(time[found.index], CLEAN[:40])
    assert found.repeated == len(repeats)
    assert found.period == pytest.approx(0.002)
    # The first to arrive of equal stamps is kept.
    assert found.index.max() < 40


def test_samples_that_came_late_are_counted() -> None:
    time = CLEAN.copy()
    time[[10, 11]] = time[[11, 10]]
    assert order(time).moved == 1
    assert order(CLEAN).moved == 0


def test_stamps_almost_equal_are_one_sample() -> None:
    found = order(np.array([0.0, 0.002, 0.0020001, 0.004, 0.006]))
    assert list(found.index) == [0, 1, 3, 4]
    assert found.repeated == 1


@given(st.lists(st.integers(1, 198), min_size=1, max_size=60, unique=True))
def test_lost_samples_do_not_bias_the_period(lost: list[int]) -> None:
    assert usual_period(np.diff(np.delete(CLEAN, lost))) == pytest.approx(0.002, rel=0.5)


def test_jitter_does_not_bias_the_period() -> None:
    jitter = np.random.default_rng(0).uniform(-2e-4, 2e-4, CLEAN.size)
    assert usual_period(np.diff(CLEAN + jitter)) == pytest.approx(0.002, rel=0.01)


def test_few_samples_have_no_period_and_no_error() -> None:
    for time in (np.empty(0), np.array([1.0]), np.array([1.0, 1.0])):
        found = order(time)
        assert np.isnan(found.period)
        assert len(found.index) == min(1, len(time))


def test_a_clock_set_back_is_told_from_disorder() -> None:
    twice = np.concatenate([10 + CLEAN, 5 + CLEAN])
    assert list(clock_resets(twice)) == [200]
    assert clock_resets(np.random.default_rng(0).permutation(100 * CLEAN)).size == 0
    late = 100 * CLEAN
    late[[50, 150]] = late[[150, 50]]
    assert clock_resets(late).size == 0


def test_what_follows_a_reset_is_moved_behind() -> None:
    time, resets = without_resets(np.concatenate([10 + CLEAN, 5 + CLEAN]))
    assert list(resets) == [200]
    assert (np.diff(time) > 0).all()
    assert time[200] - time[199] == pytest.approx(1.0)
    assert np.allclose(np.diff(time[200:]), 0.002)


PERIOD = 0.004
OMEGA = np.array([3.0, 5.0])


def moving(sampled: np.ndarray, stamped: np.ndarray) -> Recording:
    """Two joints, sampled at one time and stamped at another, with a 2e-5 rad encoder."""
    position = 2e-5 * np.round(np.sin(np.outer(sampled, OMEGA)) / 2e-5)
    effort = 3.0 + np.cos(np.outer(sampled, OMEGA))
    return Recording(("a", "b"), stamped, position, np.full_like(position, np.nan), effort)


def delays(seed: int, size: int) -> np.ndarray:
    """Mostly tens of microseconds, now and then more than a millisecond."""
    generator = np.random.default_rng(seed)
    rare = generator.random(size) < 0.01
    return generator.exponential(3e-5, size) + rare * generator.uniform(5e-4, 2e-3, size)


@settings(max_examples=15, deadline=None)
@given(
    st.integers(0, 1000),
    st.lists(st.integers(1, 2998), max_size=20, unique=True),
    st.floats(-1e-4, 1e-4),
)
def test_a_steady_clock_is_recovered_through_losses_and_drift(
    seed: int, lost: list[int], drift: float
) -> None:
    true = np.delete(PERIOD * (1 + drift) * np.arange(3000), lost)
    clock = steady_clock(true + delays(seed, len(true)), PERIOD)
    # Up to the mean delay, which nobody can see, and the wander of the fitted line.
    error = clock.steady - true
    assert np.abs(error - np.median(error)).max() < 5e-5
    assert (np.diff(clock.steady) > 0).all()


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_late_stamps_are_replaced_and_irregular_samples_are_not(seed: int) -> None:
    true = PERIOD * np.arange(3000)
    stamped = true + delays(seed, 3000)
    for sampled, replaced in ((true, True), (stamped, False)):
        notes: list[str] = []
        found = retime(moving(sampled, stamped), stamped, "auto", notes)
        assert bool(notes) == replaced
        assert np.abs(found - sampled).max() < (2e-4 if replaced else 1e-12)
        motion = condition(moving(sampled, stamped))
        inside = slice(60, -60)
        expected = -(OMEGA**2) * np.sin(np.outer(motion.time, OMEGA))
        assert np.abs(motion.qdd - expected)[inside].max() < 0.5


def test_believing_late_stamps_costs_accuracy_and_can_be_asked_for() -> None:
    true = PERIOD * np.arange(3000)
    recording = moving(true, true + delays(3, 3000))
    errors = {}
    for clock in ("stamps", "steady", "auto"):
        motion = condition(recording, Conditioning(clock=clock))
        expected = -(OMEGA**2) * np.sin(np.outer(motion.time, OMEGA))
        errors[clock] = np.abs(motion.qdd - expected)[60:-60].max()
    assert errors["auto"] == errors["steady"] < 0.3 * errors["stamps"]


def test_a_joint_that_stands_still_cannot_tell_and_keeps_its_stamps() -> None:
    stamped = PERIOD * np.arange(500) + delays(4, 500)
    recording = moving(np.zeros(500), stamped)
    notes: list[str] = []
    assert np.array_equal(retime(recording, stamped, "auto", notes), stamped)
    assert not notes


def test_repeated_and_shuffled_messages_are_retimed_alike() -> None:
    true = PERIOD * np.arange(1000)
    stamped = true + delays(5, 1000)
    clean = moving(true, stamped)
    rows = np.random.default_rng(6).permutation(np.concatenate([np.arange(1000), [3, 400, 400]]))
    dirty = replace(
        clean,
        time=clean.time[rows],
        position=clean.position[rows],
        velocity=clean.velocity[rows],
        effort=clean.effort[rows],
    )
    first, second = condition(clean), condition(dirty)
    assert any("steady clock" in note for note in second.notes)
    for name in ("time", "q", "qd", "qdd", "tau"):
        assert np.allclose(getattr(first, name), getattr(second, name), rtol=0, atol=1e-9)


def test_each_publisher_has_its_own_clock() -> None:
    true = PERIOD * np.arange(2000)
    late = true + delays(7, 2000)
    one, two = moving(true, late), moving(true + 0.4 * PERIOD, true + 0.4 * PERIOD)
    nothing = np.full((2000, 2), np.nan)
    together = Recording(
        ("a", "b", "c", "d"),
        np.concatenate([one.time, two.time]),
        np.block([[one.position, nothing], [nothing, two.position]]),
        np.full((4000, 4), np.nan),
        np.block([[one.effort, nothing], [nothing, two.effort]]),
    )
    notes: list[str] = []
    found = retime(together, together.time, "auto", notes)
    assert len(notes) == 1
    assert np.abs(found[:2000] - true).max() < 2e-4
    assert np.array_equal(found[2000:], two.time)
