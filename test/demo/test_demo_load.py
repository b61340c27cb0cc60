"""What others take of the machine: all that is used less what is ours."""

import os

import pytest

from lagrangian_ff.demo.load import OtherWork, processor_seconds

TICKS = os.sysconf("SC_CLK_TCK")


def stat(user: float, idle: float) -> str:
    return f"cpu  {round(user * TICKS)} 0 0 {round(idle * TICKS)} 0 0 0 0 0 0\ncpu0 1 2 3\n"


def test_what_is_not_ours_is_of_others() -> None:
    texts = iter([stat(100.0, 50.0), stat(106.0, 52.0)])
    ours = iter([10.0, 12.0])
    work = OtherWork(lambda: next(ours), lambda: next(texts))
    assert work.processors() == pytest.approx((os.cpu_count() or 1) * 4.0 / 8.0)


def test_a_system_that_does_not_tell_is_not_called_busy() -> None:
    def missing() -> str:
        raise FileNotFoundError

    assert OtherWork(lambda: 1.0, missing).processors() == 0.0


def test_our_own_seconds_grow_with_work() -> None:
    before = processor_seconds([os.getppid()])
    while sum(os.times()[:2]) == 0.0 or processor_seconds([]) < 0.02:
        pass
    assert processor_seconds([os.getppid(), 2**30]) >= before > 0.0
