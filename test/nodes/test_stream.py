"""The stream of torques: in time, within limits, and faded to zero whenever it must be."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from fake_model import FakeModel
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrangian_ff.nodes.common.joint_state_bytes import MessageError
from lagrangian_ff.nodes.common.status import Level
from lagrangian_ff.nodes.streaming.plan import Plan, Policy, make_plan
from lagrangian_ff.nodes.streaming.reference import Reference
from lagrangian_ff.nodes.streaming.stream import (
    Output,
    Phase,
    Settings,
    StreamMonitor,
    TorqueStream,
    clamp,
    effort_limits,
    slew,
)

MODEL = FakeModel()
SECOND = 1_000_000_000
SETTINGS = Settings(
    scale=np.ones(2), effort_limit=np.full(2, 100.0), effort_rate=np.full(2, 1e6),
    ramp_time=0.5, fade_time=0.5, reference_timeout=0.2, joint_state_timeout=0.3,
    tracking_tolerance=0.0,
)  # fmt: skip


def constant_speed(seconds: float = 4.0, speed: float = 0.2) -> Plan:
    time = np.array([0.0, seconds])
    q = np.column_stack([speed * time, -speed * time])
    qd = np.tile([speed, -speed], (2, 1))
    reference = Reference(("a", "b"), time, q, qd, np.zeros((2, 2)))
    return make_plan(MODEL, reference, Policy("allow"))


def setpoint(q: float = 0.5) -> Plan:
    still = np.zeros((1, 2))
    reference = Reference(("a", "b"), np.zeros(1), np.full((1, 2), q), still, still)
    return make_plan(MODEL, reference, Policy("allow"))


class Bench:
    """A stream and the clocks it lives by: both start at 0 and tick together, 500 Hz."""

    def __init__(self, **changes: Any) -> None:
        self.stream = TorqueStream(("a", "b"), replace(SETTINGS, **changes))
        self.now = 0.0
        self.alive = True
        self.delay = 0.0
        self.position: Callable[[float], np.ndarray] = lambda time: np.zeros(2)

    def play(self, plan: Plan, start: float = 0.0) -> None:
        self.stream.play(plan, round(start * SECOND), self.now)

    def run(self, seconds: float) -> list[Output]:
        outputs = []
        for _ in range(round(seconds * 500)):
            if self.alive:
                stamp = round((self.now - self.delay) * SECOND)
                self.stream.joint_state_came(self.now, stamp, self.position(self.now - self.delay))
            outputs.append(self.stream.tick(round(self.now * SECOND), self.now))
            self.now += 0.002
        return outputs


def expected(plan: Plan, elapsed: float) -> np.ndarray:
    states = plan.reference.sample(np.array([elapsed]))
    return MODEL.predict(*states)[0]


def test_without_a_reference_the_torque_is_zero() -> None:
    for output in Bench().run(0.1):
        assert not output.tau.any()
        assert output.phase is Phase.WAITING


def test_it_is_brought_in_by_a_ramp_and_then_follows_in_time() -> None:
    bench = Bench()
    plan = constant_speed()
    bench.play(plan, start=1.0)
    ahead = bench.run(1.0)
    gains = [output.gain for output in ahead]
    assert gains[0] == 0.0
    assert gains[124] == pytest.approx(0.5, abs=0.01)
    assert gains[-1] == 1.0
    assert ahead[-1].phase is Phase.AHEAD
    np.testing.assert_allclose(ahead[-1].tau, [10.0, 10.0])
    output = bench.run(1.0)[-1]
    assert output.phase is Phase.FOLLOWING
    np.testing.assert_allclose(output.tau, expected(plan, 0.998), atol=1e-6)
    assert output.q is not None
    np.testing.assert_allclose(output.q, 0.998 * np.array([0.2, -0.2]))


def test_lead_sends_the_torque_of_a_later_instant() -> None:
    bench = Bench(lead=0.01, ramp_time=0.0)
    plan = constant_speed()
    bench.play(plan)
    output = bench.run(0.5)[-1]
    np.testing.assert_allclose(output.tau, expected(plan, 0.508), atol=1e-6)


@pytest.mark.parametrize(("after_end", "gain"), [("hold", 1.0), ("fade", 0.0)])
def test_after_the_end_gravity_is_held_or_faded(after_end: str, gain: float) -> None:
    bench = Bench(after_end=after_end)
    bench.play(constant_speed(1.0))
    output = bench.run(2.0)[-1]
    assert output.phase is Phase.HOLDING
    np.testing.assert_allclose(output.tau, gain * 10.0 * np.cos([0.2, -0.2]), atol=1e-9)


def test_the_running_trajectory_goes_on_until_the_next_one_starts() -> None:
    bench = Bench(ramp_time=0.0)
    first, second = constant_speed(), constant_speed(speed=1.0)
    bench.play(first)
    bench.run(1.0)
    bench.play(second, start=2.0)
    np.testing.assert_allclose(bench.run(0.5)[-1].tau, expected(first, 1.498), atol=1e-6)
    np.testing.assert_allclose(bench.run(1.0)[-1].tau, expected(second, 0.498), atol=1e-4)


def faded(outputs: list[Output], fade_time: float = 0.5) -> None:
    """Check that the gain and the torque fall steadily to zero within the fade time."""
    gains = np.array([output.gain for output in outputs])
    assert (np.diff(gains) <= 0.0).all()
    assert np.diff(gains).min() >= -0.002 / fade_time - 1e-9
    assert not outputs[-1].tau.any()
    assert outputs[-1].withheld


def test_silent_joint_states_fade_it_and_new_ones_bring_it_back() -> None:
    bench = Bench()
    bench.play(constant_speed())
    bench.run(1.0)
    bench.alive = False
    outputs = bench.run(0.3 + 0.5 + 0.05)
    faded(outputs)
    assert "no joint states" in outputs[-1].withheld
    assert outputs[-1].silent
    bench.alive = True
    assert bench.run(0.6)[-1].gain == 1.0


def test_a_robot_that_is_not_where_its_reference_is_gets_no_torque() -> None:
    bench = Bench(tracking_tolerance=0.3)
    bench.play(constant_speed())
    assert bench.run(1.4)[-1].gain == 1.0
    outputs = bench.run(0.7)
    faded([output for output in outputs if output.withheld])
    assert outputs[-1].withheld == "a is more than 0.3 rad from its reference"
    bench.position = lambda time: np.array([0.5, -0.5])
    assert bench.run(0.6)[-1].gain == 1.0


def test_joint_states_that_come_late_are_compared_with_the_reference_of_their_time() -> None:
    bench = Bench(tracking_tolerance=0.05, ramp_time=0.0)
    bench.delay = 0.5
    bench.position = lambda time: max(time, 0.0) * np.array([0.5, -0.5])
    bench.play(constant_speed(speed=0.5))
    assert not any(output.withheld for output in bench.run(3.0))


def test_silent_set_points_fade_it() -> None:
    bench = Bench()
    for _ in range(60):
        bench.play(setpoint(), bench.now)
        output = bench.run(0.02)[-1]
    assert output.gain == 1.0
    assert output.phase is Phase.STREAMED
    faded(bench.run(0.2 + 0.5 + 0.05))


def test_timeouts_of_zero_are_off() -> None:
    bench = Bench(reference_timeout=0.0, joint_state_timeout=0.0)
    bench.alive = False
    bench.play(setpoint())
    assert bench.run(5.0)[-1].gain == 1.0


def test_at_its_end_no_reference_brings_the_torque_back() -> None:
    bench = Bench()
    for _ in range(20):
        bench.play(setpoint())
        bench.run(0.05)
    bench.stream.end("deactivated")
    gains = []
    for _ in range(12):
        bench.play(setpoint())
        gains += [output.gain for output in bench.run(0.05)]
    assert np.all(np.diff(gains) <= 0.0)
    assert max(-np.diff(gains)) < 0.01
    assert gains[-1] == 0.0
    assert bench.run(0.01)[-1].withheld == "deactivated"
    bench.stream.forget()
    bench.play(setpoint())
    assert bench.run(0.1)[-1].gain > 0.0


def test_disable_and_withhold_fade_it_and_a_good_reference_brings_it_back() -> None:
    bench = Bench()
    bench.play(constant_speed())
    bench.run(1.0)
    bench.stream.enabled = False
    faded(bench.run(0.6))
    bench.stream.enabled = True
    assert bench.run(0.6)[-1].gain == 1.0
    bench.stream.withhold("outside")
    faded(bench.run(0.6))
    bench.play(constant_speed(), bench.now)
    assert bench.run(0.6)[-1].gain == 1.0


def test_a_stall_of_the_machine_is_not_followed_by_a_jump() -> None:
    bench = Bench()
    bench.play(constant_speed())
    bench.run(1.0)
    bench.stream.enabled = False
    bench.now += 0.3
    gain = bench.run(0.002)[0].gain
    assert 0.9 < gain < 1.0


def test_saturation_is_clamped_and_flagged() -> None:
    bench = Bench(ramp_time=0.0, effort_limit=np.array([4.0, 100.0]))
    bench.play(constant_speed())
    output = bench.run(0.1)[-1]
    assert output.tau[0] == 4.0
    assert output.saturated.tolist() == [True, False]


def test_a_jump_of_the_reference_is_taken_at_the_rate_limit() -> None:
    bench = Bench(ramp_time=0.0, effort_rate=np.full(2, 10.0), reference_timeout=0.0)
    bench.play(setpoint(1.5))
    bench.run(0.5)
    bench.play(setpoint(0.0), bench.now)
    outputs = bench.run(0.5)
    jumps = np.abs(np.diff([output.tau for output in outputs], axis=0))
    assert jumps.max() <= 10.0 * 0.002 + 1e-9
    assert outputs[-1].held_back.all()


def test_switches_and_scale_act_at_once() -> None:
    bench = Bench(ramp_time=0.0)
    bench.play(constant_speed())
    bench.run(0.5)
    bench.stream.settings = replace(
        bench.stream.settings, switches=np.array([0.0, 0, 0, 1]), scale=np.array([1.0, 0.5])
    )
    tau = bench.run(0.1)[-1].tau
    np.testing.assert_allclose(tau, [1.1, -0.55], atol=1e-6)


def test_forget_is_silence_at_once() -> None:
    bench = Bench()
    bench.play(constant_speed())
    bench.run(1.0)
    bench.stream.forget()
    assert not bench.run(0.01)[0].tau.any()


events = st.sampled_from(
    ("trajectory", "setpoint", "late", "withhold", "disable", "enable", "dead", "alive", "wait")
)


@settings(max_examples=15, deadline=None)
@given(st.lists(events, max_size=12))
def test_whatever_happens_the_torque_is_finite_limited_and_has_no_frozen_last_value(
    script: list[str],
) -> None:
    bench = Bench(effort_limit=np.array([5.0, 8.0]), effort_rate=np.full(2, 500.0))
    tau: list[np.ndarray] = []
    for event in script:
        if event == "trajectory":
            bench.play(constant_speed(0.3), bench.now + 0.05)
        elif event == "late":
            bench.play(constant_speed(1.0, 1.0), bench.now - 0.5)
        elif event == "setpoint":
            bench.play(setpoint(), bench.now)
        elif event == "withhold":
            bench.stream.withhold("outside")
        elif event in ("disable", "enable"):
            bench.stream.enabled = event == "enable"
        elif event in ("dead", "alive"):
            bench.alive = event == "alive"
        tau += [output.tau for output in bench.run(0.1)]
    bench.alive = False
    end = bench.run(1.0)[-1]
    assert not end.tau.any()
    table = np.array([*tau, np.zeros(2)])
    assert np.isfinite(table).all()
    assert (np.abs(table) <= [5.0, 8.0]).all()
    # No step larger than a ramp of the largest torque and the rate limit together allow.
    assert np.abs(np.diff(table[:-1], axis=0)).max(initial=0.0) <= 8.0 * 0.004 + 1.0 + 1e-9


@given(st.floats(-50, 50), st.floats(-50, 50), st.floats(0.1, 100), st.floats(0, 0.1))
def test_slew_and_clamp(previous: float, wanted: float, rate: float, dt: float) -> None:
    moved, held = slew(np.array([previous]), np.array([wanted]), np.array([rate]), dt)
    assert abs(moved[0] - previous) <= rate * dt + 1e-12
    assert held[0] or moved[0] == pytest.approx(wanted, abs=1e-9)
    cut, flagged = clamp(np.array([wanted]), np.array([rate]))
    assert abs(cut[0]) <= rate
    assert flagged[0] == (abs(wanted) > rate)


def test_ramp_without_duration_is_a_switch() -> None:
    bench = Bench(ramp_time=0.0, fade_time=0.0)
    bench.play(constant_speed())
    assert bench.run(0.002)[0].gain == 1.0
    bench.stream.enabled = False
    assert bench.run(0.002)[0].gain == 0.0


def output(
    phase: Phase = Phase.FOLLOWING,
    withheld: str = "",
    saturated: bool = False,
    silent: bool = False,
) -> Output:
    flags, none = np.array([saturated, False]), np.zeros(2, dtype=bool)
    return Output(np.zeros(2), 1.0, phase, withheld, flags, none, silent=silent)


def test_each_beginning_of_a_fade_is_reported_once() -> None:
    monitor = StreamMonitor()
    reasons = [
        monitor.note(output(withheld=reason))
        for reason in ("", "disabled", "disabled", "", "no joint states", "no joint states")
    ]
    assert reasons == ["", "disabled", "", "", "no joint states", ""]
    assert StreamMonitor().note(output(Phase.WAITING, "no reference")) == ""


@pytest.mark.parametrize(
    ("last", "rate", "level", "message"),
    [
        (output(), 0.0, Level.OK, "following"),
        (output(Phase.WAITING, "no reference"), 0.0, Level.OK, "no reference"),
        (output(withheld="disabled"), 0.0, Level.WARN, "disabled"),
        (output(withheld="no joint states", silent=True), 0.0, Level.STALE, "no joint states"),
        (output(saturated=True), 0.0, Level.WARN, "torque limit reached in 1 ticks"),
        (output(), 1e12, Level.WARN, "Hz instead of 1e+12 Hz"),
    ],
)
def test_the_status_names_the_worst(last: Output, rate: float, level: Level, message: str) -> None:
    monitor = StreamMonitor()
    monitor.note(last)
    status = monitor.status(rate, {"more": 1})
    assert status.level is level
    assert message in status.message
    assert status.values["more"] == 1
    assert monitor.status(0.0, {}).values["ticks at the torque limit"] == 0


def test_positive_limits_are_found_by_joint() -> None:
    urdf = """<robot name="r">
      <joint name="a" type="revolute"><limit effort="12.5" velocity="1"/></joint>
      <joint name="b" type="continuous"><limit effort="0" velocity="1"/></joint>
      <joint name="c" type="fixed"/>
      <joint name="d" type="prismatic"><limit velocity="1"/></joint>
    </robot>"""
    assert effort_limits(urdf) == {"a": 12.5}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "not XML"),
        ("<robot>", "not XML"),
        ('<robot><joint name="a"><limit effort="strong"/></joint></robot>', "limit of a"),
    ],
)
def test_what_is_no_description_is_reported(text: str, expected: str) -> None:
    with pytest.raises(MessageError, match=expected):
        effort_limits(text)
