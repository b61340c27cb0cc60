"""A torque that is passed on, within limits, and fades to zero when it stops."""

from dataclasses import replace

import numpy as np
import pytest

from lagrangian_ff.nodes.streaming.guard import NO_LIMIT, Guard, GuardSettings

SETTINGS = GuardSettings(
    np.array([10.0, 10.0]), np.array([200.0, 200.0]), timeout=0.1, fade_time=0.5, ramp_time=0.1
)


def run(guard: Guard, begin: float, seconds: float, tau: list[float] | None) -> np.ndarray:
    """Tick at 500 Hz with a message at every tick or with none; return what was sent last."""
    sent: list[np.ndarray] = []
    before = np.zeros(2) if guard.sent is None else guard.sent
    for steady in np.arange(begin, begin + seconds, 0.002):
        if tau is not None:
            guard.take(np.array(tau), steady)
        now = guard.tick(steady)
        last = sent[-1] if sent else before
        sent.append(last if now is None else now)
    return np.array(sent)


def test_before_the_first_torque_nothing_is_sent() -> None:
    assert Guard(SETTINGS, 2).tick(1.0) is None


def test_it_is_brought_in_passed_on_and_faded() -> None:
    guard = Guard(SETTINGS, 2)
    passed = run(guard, 0.0, 0.3, [5.0, -3.0])
    assert np.abs(passed[25]).max() < 3.0
    np.testing.assert_allclose(passed[-1], [5.0, -3.0])
    silent = run(guard, 0.3, 0.7, None)
    np.testing.assert_allclose(silent[45], [5.0, -3.0])
    assert not silent[round(0.61 / 0.002)].any()
    assert guard.silent
    assert np.abs(np.diff(np.vstack([passed, silent]), axis=0)).max() <= 200.0 * 0.002 + 1e-9
    again = run(guard, 1.0, 0.3, [5.0, -3.0])
    assert np.abs(again[10]).max() < 2.0
    np.testing.assert_allclose(again[-1], [5.0, -3.0])


def test_limits_hold_and_a_jump_takes_its_time() -> None:
    guard = Guard(SETTINGS, 2)
    sent = run(guard, 0.0, 0.3, [400.0, 0.0])
    assert sent[-1].tolist() == [10.0, 0.0]
    sent = run(guard, 0.3, 0.02, [-400.0, 0.0])
    assert np.abs(np.diff(sent[:, 0])).max() <= 0.4 + 1e-9


@pytest.mark.parametrize("bad", [[1.0], [1.0, np.nan], [np.inf, 1.0], []])
def test_what_is_no_torque_is_not_passed_on_and_is_no_sign_of_life(bad: list[float]) -> None:
    guard = Guard(SETTINGS, 2)
    run(guard, 0.0, 0.3, [5.0, -3.0])
    assert guard.take(np.array(bad), 0.3)
    sent = run(guard, 0.3, 0.7, bad)
    assert np.isfinite(sent).all()
    assert not sent[-1].any()


def test_without_joints_any_number_passes_without_limits_and_then_only_that() -> None:
    free = replace(
        SETTINGS, effort_limit=np.array([NO_LIMIT]), effort_rate=np.array([20 * NO_LIMIT])
    )
    guard = Guard(free)
    assert run(guard, 0.0, 0.3, [500.0, 1.0])[-1].tolist() == [500.0, 1.0]
    assert guard.take(np.ones(3), 0.3) == "3 torques; expected 2"


def test_after_a_stall_it_makes_up_for_three_periods_only() -> None:
    guard = Guard(SETTINGS, 2)
    run(guard, 0.0, 0.3, [5.0, -3.0])
    before = guard.sent
    after = guard.tick(10.0)
    assert before is not None
    assert after is not None
    assert 0.0 < np.abs(after - before).max() <= 200.0 * 0.006 + 1e-9


def test_ended_it_fades_though_torques_go_on() -> None:
    guard = Guard(SETTINGS, 2)
    run(guard, 0.0, 0.3, [5.0, -3.0])
    guard.end()
    assert not run(guard, 0.3, 0.6, [5.0, -3.0])[-1].any()
    assert guard.resting


@pytest.mark.parametrize("pause", [0.02, 0.05])
def test_a_torque_that_pauses_while_it_is_brought_in_does_not_jump(pause: float) -> None:
    """Whatever moves the torque between two messages is sent."""
    guard = Guard(SETTINGS, 2)
    sent = np.vstack(
        [
            run(guard, 0.0, 0.02, [8.0, -3.0]),
            run(guard, 0.02, pause, None),
            run(guard, 0.02 + pause, 0.2, [8.0, -3.0]),
        ]
    )
    assert np.abs(np.diff(sent, axis=0)).max() <= 200.0 * 0.002 + 1e-9
    np.testing.assert_allclose(sent[-1], [8.0, -3.0])


def test_a_torque_at_rest_is_sent_once_for_each_message() -> None:
    guard = Guard(SETTINGS, 2)
    run(guard, 0.0, 0.3, [5.0, -3.0])
    assert guard.tick(0.302) is None
    guard.take(np.array([5.0, -3.0]), 0.304)
    assert guard.tick(0.304) is not None
