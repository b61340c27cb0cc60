"""How far the torque may move from one message to the next."""

from dataclasses import replace

import numpy as np
import pytest
from fake_model import FakeModel
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrangian_ff.nodes.streaming.plan import Plan, Policy, make_plan
from lagrangian_ff.nodes.streaming.reference import Reference
from lagrangian_ff.nodes.streaming.stream import Output, Settings, TorqueStream

SECOND = 1_000_000_000
LIMIT = np.full(2, 20.0)
SETTINGS = Settings(
    scale=np.ones(2), effort_limit=LIMIT, effort_rate=20.0 * LIMIT, ramp_time=0.5, fade_time=0.5,
    joint_state_timeout=0.0, tracking_tolerance=0.0, longest=0.006,
)  # fmt: skip


def standing(q: float, points: int = 1) -> Plan:
    still = np.zeros((points, 2))
    time = np.arange(float(points))
    reference = Reference(("a", "b"), time, np.full((points, 2), q), still, still)
    return make_plan(FakeModel(), reference, Policy("allow"))


class Clock:
    """A stream, ticked whenever the test says."""

    def __init__(self, settings: Settings = SETTINGS) -> None:
        self.stream = TorqueStream(("a", "b"), settings)
        self.steady, self.ahead = 100.0, 0.0
        self.last = np.zeros(2)
        self.stream.tick(self.now, self.steady)

    @property
    def now(self) -> int:
        return round((self.steady + self.ahead) * SECOND)

    def tick(self, after: float) -> Output:
        """Tick once and check that the torque moved no farther than it may."""
        self.steady += after
        output = self.stream.tick(self.now, self.steady)
        now = self.stream.settings
        most = now.quickest(bool(output.withheld)) * min(after, now.longest)
        assert (np.abs(output.tau - self.last) <= most + 1e-9).all()
        self.last = output.tau
        return output

    def run(self, seconds: float) -> list[Output]:
        return [self.tick(0.002) for _ in range(round(seconds * 500))]


@pytest.mark.parametrize("stall", [0.01, 0.1, 3.0])
def test_after_a_starved_tick_the_torque_moves_by_three_periods_at_most(stall: float) -> None:
    clock = Clock(replace(SETTINGS, ramp_time=0.0, reference_timeout=0.0))
    clock.stream.play(standing(1.5), clock.now, clock.steady)
    clock.run(0.2)
    clock.stream.play(standing(0.0), clock.now, clock.steady)
    before = clock.last
    output = clock.tick(stall)
    assert np.abs(output.tau - before).max() == pytest.approx(400.0 * 0.006)


def test_ramp_and_fade_without_duration_keep_to_the_rate_limit_and_to_one_tick() -> None:
    clock = Clock(replace(SETTINGS, ramp_time=0.0, fade_time=0.0))
    clock.stream.play(standing(0.0), clock.now, clock.steady)
    assert clock.tick(0.002).tau[0] == pytest.approx(0.8)
    clock.stream.enabled = False
    assert not clock.tick(0.002).tau.any()


def test_a_dropped_reference_does_not_drop_the_torque_at_once() -> None:
    clock = Clock()
    clock.stream.play(standing(0.0, 5), clock.now, clock.steady)
    clock.run(1.0)
    clock.stream.drop()
    taus = [output.tau[0] for output in clock.run(0.1)]
    assert taus[0] > 9.0
    assert taus[-1] == 0.0


@pytest.mark.parametrize("jump", [-3600.0, 3600.0])
def test_a_clock_that_jumps_fades_where_the_motion_is_until_the_next_reference(jump: float) -> None:
    clock = Clock()
    clock.stream.play(standing(0.0, 5), clock.now, clock.steady)
    clock.run(1.0)
    clock.ahead += jump
    outputs = clock.run(0.55)
    assert "the clock was set" in outputs[0].withheld
    assert "3600.0 s: send a new reference" in outputs[0].withheld
    assert outputs[0].tau[0] > 9.9
    assert not outputs[-1].tau.any()
    clock.stream.play(standing(0.0, 5), clock.now, clock.steady)
    assert clock.run(0.6)[-1].gain == 1.0


def test_a_simulated_clock_that_is_set_back_fades_and_then_follows_again() -> None:
    clock = Clock()
    clock.stream.play(standing(0.0, 5), clock.now, clock.steady)
    clock.run(1.0)
    clock.steady -= 90.0
    clock.stream.tick(clock.now, clock.steady)
    outputs = clock.run(0.6)
    assert "set back by 90.0 s" in outputs[0].withheld
    assert not outputs[-1].tau.any()
    clock.stream.play(standing(0.0), clock.now, clock.steady)
    assert clock.run(0.1)[-1].gain > 0.0
    assert "no set-point" in clock.run(0.3)[-1].withheld


events = st.tuples(
    st.sampled_from(("jump", "set-point", "drop", "disable", "enable", "withhold", "clock")),
    st.lists(st.sampled_from((0.0, 0.0001, 0.002, 0.004, 0.02, 0.5)), max_size=20),
)


@settings(max_examples=30, deadline=None)
@given(st.lists(events, max_size=12))
def test_whatever_happens_no_message_moves_the_torque_farther_than_it_may(
    script: list[tuple[str, list[float]]],
) -> None:
    clock = Clock(replace(SETTINGS, ramp_time=0.0, fade_time=0.1))
    for k, (event, ticks) in enumerate(script):
        if event == "jump":
            clock.stream.play(standing(k % 3 - 1.0, 3), clock.now, clock.steady)
        elif event == "set-point":
            clock.stream.play(standing(3.0 * (k % 2)), clock.now, clock.steady)
        elif event == "drop":
            clock.stream.drop()
        elif event == "withhold":
            clock.stream.withhold("outside")
        elif event == "clock":
            clock.ahead += 100.0 * (-1) ** k
        else:
            clock.stream.enabled = event == "enable"
        for after in ticks:
            tau = clock.tick(after).tau
            assert (np.abs(tau) <= LIMIT).all()
