"""The clock-paced loop keeps its grid whatever sleeping does to it."""

import threading

from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.nodes.common.pacing import FollowingPacer, PacedThread, Pacer, RateMeter

PERIOD = 2_000_000


class SleepyClock:
    """A clock that only moves when slept on, each time longer than asked by the next delay."""

    def __init__(self, delays: list[int]) -> None:
        self.now = 0
        self.delays = delays

    def __call__(self) -> int:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += round(seconds * 1e9) + (self.delays.pop(0) if self.delays else 0)


delays = st.lists(st.integers(0, 12_000_000), max_size=40)


@given(delays, st.integers(1, 5))
def test_skipping_works_off_the_newest_and_counts_the_rest(slow: list[int], most: int) -> None:
    clock = SleepyClock(list(slow))
    pacer = Pacer(0.002, most, clock=clock, sleep=clock.sleep)
    worked: list[int] = []
    for _ in range(len(slow) + 5):
        due = pacer.wait()
        assert 1 <= len(due) <= most
        assert pacer.instant(due[-1]) <= clock.now < pacer.instant(due[-1] + 1)
        worked += due
    assert worked == sorted(set(worked))
    assert len(worked) + pacer.skipped == worked[-1]
    assert pacer.behind == 0.0


@given(delays, st.integers(2, 5))
def test_without_skipping_every_instant_is_worked_off_in_order(slow: list[int], most: int) -> None:
    clock = SleepyClock(list(slow))
    pacer = Pacer(0.002, most, skip=False, clock=clock, sleep=clock.sleep)
    worked: list[int] = []
    while not worked or clock.delays or pacer.behind > 0.0:
        due = pacer.wait()
        assert 1 <= len(due) <= most
        assert pacer.instant(due[-1]) <= clock.now
        worked += due
    assert worked == list(range(1, worked[-1] + 1))
    assert pacer.skipped == 0
    assert (pacer.late > 0) == any(delay >= PERIOD for delay in slow)


def test_a_punctual_clock_is_never_late() -> None:
    clock = SleepyClock([])
    pacer = Pacer(0.002, clock=clock, sleep=clock.sleep)
    assert [pacer.wait()[0] for _ in range(100)] == list(range(1, 101))
    assert clock.now == 100 * PERIOD
    assert pacer.late == pacer.skipped == 0


@given(st.lists(st.integers(0, 9_000_000), max_size=40))
def test_following_works_off_each_instant_of_another_clock_once(steps: list[int]) -> None:
    clock = SleepyClock([])
    waiting = list(steps)

    def rest() -> None:
        clock.now += waiting.pop(0)

    pacer = FollowingPacer(0.002, clock, rest)
    for _ in steps:
        before = clock.now // PERIOD
        due = pacer.wait()
        after = clock.now // PERIOD
        assert list(due) == ([after] if after > before else [])


def test_following_goes_on_from_where_a_clock_is_set_back_to() -> None:
    clock = SleepyClock([])
    instants = iter([10, 11, 10, 12, 2000, 3, 3, 4])

    def rest() -> None:
        clock.now = next(instants) * PERIOD

    pacer = FollowingPacer(0.002, clock, rest)
    worked = [list(pacer.wait()) for _ in range(8)]
    assert worked == [[10], [11], [], [12], [2000], [3], [], [4]]


def test_the_speed_may_be_changed_and_instants_stopped() -> None:
    clock = SleepyClock([])
    pacer = Pacer(0.002, clock=clock, sleep=clock.sleep)

    def took(count: int) -> int:
        before = clock.now
        assert all(len(pacer.wait()) == 1 for _ in range(count))
        return clock.now - before

    assert took(100) == 100 * PERIOD
    pacer.speed = 2.0
    assert took(100) == 50 * PERIOD
    pacer.speed = 0.0
    assert not any(len(pacer.wait()) for _ in range(100))
    assert clock.now > 150 * PERIOD
    assert pacer.behind == 0.0
    pacer.speed = 0.5
    assert took(100) == 200 * PERIOD
    assert pacer.late == pacer.skipped == 0


def test_the_thread_goes_on_after_a_failure_and_ends_when_stopped() -> None:
    done = threading.Event()
    failures: list[Exception] = []
    calls = 0

    def work(due: range) -> None:
        nonlocal calls
        calls += 1
        if calls == 1:
            raise ValueError("the first one fails")
        done.set()

    thread = PacedThread(Pacer(0.001), work, failures.append, "test")
    assert done.wait(5.0)
    thread.stop()
    after = calls
    assert not done.wait(0.0) or calls == after
    assert [str(error) for error in failures] == ["the first one fails"]


def test_the_thread_survives_a_clock_and_a_report_that_fail() -> None:
    done = threading.Event()
    waits = 0

    class Failing:
        def wait(self) -> range:
            nonlocal waits
            waits += 1
            if waits < 3:
                raise OSError("no clock")
            return range(1)

    def failed(error: Exception) -> None:
        raise ValueError("nowhere to report")

    thread = PacedThread(Failing(), lambda due: done.set(), failed, "test")
    assert done.wait(5.0)
    thread.stop()


def test_rate_meter_starts_again_each_time() -> None:
    times = iter([0.0, 2.0, 3.0])
    meter = RateMeter(lambda: next(times))
    meter.add(10)
    assert meter.take() == 5.0
    meter.add()
    assert meter.take() == 1.0
