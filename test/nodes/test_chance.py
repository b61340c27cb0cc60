"""The threshold that chance passes once in hours."""

from collections.abc import Callable

import numpy as np
import pytest

from lagrangian_ff.arrays import Floats
from lagrangian_ff.nodes.watching.chance import APART, LEARNING, Chance, once_in

JOINTS = 6
HOUR = 3600.0


def power(u: Floats) -> Floats:
    return np.asarray(u ** (-1.0 / 6.0))


def exponential(u: Floats) -> Floats:
    return np.asarray(-np.log(u))


@pytest.mark.parametrize("tail", [power, exponential])
def test_once_in_an_hour_is_what_a_known_tail_gives(tail: Callable[[Floats], Floats]) -> None:
    random = np.random.default_rng(0)
    truth = float(tail(np.array(1.0 / HOUR)))
    found = [once_in(HOUR, tail(1.0 - random.random((400, JOINTS)))) for _ in range(20)]
    assert truth < np.median(found) < 1.7 * truth
    assert np.mean(np.array(found) > 0.8 * truth) > 0.95


def learned(seconds: int, alarms: Callable[[int], bool] = lambda _: False) -> Chance:
    """Return what is learned from seconds of normal noise, ten outputs in each."""
    random = np.random.default_rng(1)
    chance, counts = Chance(JOINTS, 1.0), np.ones(JOINTS, dtype=bool)
    for second in range(seconds):
        alarm = alarms(second)
        for k in range(10):
            z = np.abs(random.normal(size=JOINTS)) + 50.0 * alarm
            chance.take(round((second + 0.1 * k) * 1e9), z, counts, alarm)
    return chance


def test_there_is_no_alarm_before_enough_was_seen() -> None:
    assert np.all(np.isinf(learned(LEARNING).threshold))
    assert np.all(np.isfinite(learned(LEARNING + 2).threshold))


def test_touches_one_after_the_other_do_not_make_it_deaf() -> None:
    quiet, touched = (
        learned(500, alarms).threshold for alarms in (lambda _: False, lambda s: s >= 400)
    )
    assert np.all(touched < 1.2 * quiet)


def test_where_the_arm_changed_for_good_the_threshold_follows() -> None:
    """Alarms that never end are learned from at last, if slowly."""
    alarms = [learned(400 + many * APART, lambda s: s >= 400).threshold for many in (0, 10, 60)]
    assert np.all(alarms[0] < alarms[1])
    assert np.all(alarms[1] < alarms[2])


def test_a_second_that_was_hardly_judged_is_not_learned_from() -> None:
    chance = learned(10)
    before = chance.learned
    for second in range(20, 40):
        chance.take(second * 10**9, np.ones(JOINTS), np.ones(JOINTS, dtype=bool), False)
    assert chance.learned <= before + 1
