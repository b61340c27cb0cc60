"""Joint states as signs of life: what their stamps say."""

import pytest

from lagrangian_ff.nodes.common.status import Level
from lagrangian_ff.nodes.streaming.life import SignsOfLife

SECOND = 1_000_000_000
NOW = 1_700_000_000 * SECOND
PERIOD = SECOND // 100


def judged(stamps: list[int], publishers: int = 1) -> tuple[list[int | None], Level, str]:
    """Return when states that come every 10 ms were true, and the status after them."""
    life = SignsOfLife()
    news = [life.news(stamp, NOW + k * PERIOD) for k, stamp in enumerate(stamps)]
    status = life.status(publishers)
    return news, status.level, status.message


def test_states_in_order_are_true_at_their_stamps() -> None:
    stamps = [NOW + k * PERIOD - 3_000_000 for k in range(5)]
    assert judged(stamps) == (stamps, Level.OK, "5 joint states in the last second")


def test_states_without_a_stamp_are_true_when_they_come() -> None:
    assert judged([0, 0])[0] == [NOW, NOW + PERIOD]


@pytest.mark.parametrize("hours", [-1, 1])
def test_stamps_an_hour_off_are_said_and_the_time_of_arrival_counts(hours: int) -> None:
    news, level, message = judged([NOW + hours * 3600 * SECOND + k * PERIOD for k in range(3)])
    assert news == [NOW, NOW + PERIOD, NOW + 2 * PERIOD]
    assert level is Level.WARN
    assert "3600.0 s" in message
    assert "NTP" in message


def test_a_state_repeated_for_ever_is_no_sign_of_life() -> None:
    life = SignsOfLife()
    assert life.news(NOW, NOW) == NOW
    life.status(1)
    assert [life.news(NOW, NOW + k) for k in range(3)] == [None] * 3
    status = life.status(1)
    assert status.level is Level.WARN
    assert "repeats an old state" in status.message


def test_each_state_sent_twice_is_usual() -> None:
    news, level, _ = judged([NOW, NOW, NOW + PERIOD, NOW + PERIOD])
    assert news == [NOW, None, NOW + PERIOD, None]
    assert level is Level.OK


def test_two_publishers_are_noticed_by_the_order_of_stamps() -> None:
    news, level, message = judged([NOW, NOW - PERIOD // 2, NOW + PERIOD], publishers=2)
    assert news == [NOW, None, NOW + PERIOD]
    assert level is Level.WARN
    assert "2 publish there" in message


def test_a_driver_whose_clock_was_set_back_is_alive() -> None:
    news, level, message = judged([NOW, NOW - 60 * SECOND, NOW - 60 * SECOND + PERIOD])
    assert news == [NOW, NOW + PERIOD, NOW + 2 * PERIOD]
    assert level is Level.WARN
    assert "went back in time" in message


@pytest.mark.parametrize(("publishers", "expected"), [(0, "nobody publishes"), (2, "though 2")])
def test_silence_is_stale(publishers: int, expected: str) -> None:
    _, level, message = judged([], publishers)
    assert level is Level.STALE
    assert expected in message
