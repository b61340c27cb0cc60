"""Live joint states: found by name, filtered alike, never across an interruption."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from small_model import JOINTS, motion_at, torque_of

from lagrangian_ff.nodes.common.joint_state_bytes import JointStateView, MessageError
from lagrangian_ff.nodes.watching.states import MEASURED, CausalFilter, LiveStates, State
from lagrangian_ff.recording import Conditioning, Recording, condition

Floats = NDArray[np.float64]


def filtered(order: int, bandwidth: float, time: Floats, values: Floats) -> list[Floats]:
    """Return the output and its derivatives, (M - 1,) each, after each sample but the first."""
    low_pass = CausalFilter(order, bandwidth)
    low_pass.start(values[:1])
    outputs = []
    for passed, value in zip(np.diff(time), values[1:], strict=True):
        low_pass.take(passed, np.array([value]))
        outputs.append(low_pass.output())
    return [np.concatenate(each) for each in zip(*outputs, strict=True)]


@pytest.mark.parametrize("order", [1, 2, 3, 4])
@pytest.mark.parametrize("frequency", [2.0, 10.0, 20.0])
def test_the_gain_is_that_of_forward_and_backward(order: int, frequency: float) -> None:
    time = np.arange(0.0, 2.0, 0.0005)
    y, yd, ydd = filtered(order, 10.0, time, np.sin(2.0 * np.pi * frequency * time))
    late = slice(len(time) // 2, None)
    amplitude = np.ptp(y[late]) / 2.0
    assert amplitude == pytest.approx(1.0 / (1.0 + (frequency / 10.0) ** (2 * order)), rel=0.01)
    speed = 2.0 * np.pi * frequency
    assert np.ptp(yd[late]) / 2.0 == pytest.approx(amplitude * speed, rel=0.01)
    # The second derivative of straight pieces through an order of 1 has steps.
    assert np.ptp(ydd[late]) / 2.0 == pytest.approx(amplitude * speed**2, rel=0.02)


@given(
    st.floats(-3.0, 3.0),
    st.floats(-2.0, 2.0),
    st.lists(st.floats(1e-4, 0.02), min_size=5, max_size=20),
)
def test_a_straight_line_comes_late_by_the_delay_however_it_is_sampled(
    begin: float, slope: float, steps: list[float]
) -> None:
    time = np.cumsum(np.resize(steps, 400 + int(1.0 / np.mean(steps))))
    low_pass = CausalFilter(3, 25.0)
    y, yd, ydd = filtered(3, 25.0, time, begin + slope * time)
    late = time[1:] > time[0] + 3.0 * low_pass.settled
    expected = begin + slope * (time[1:] - low_pass.delay)
    np.testing.assert_allclose(y[late], expected[late], atol=1e-5)
    np.testing.assert_allclose(yd[late], slope, atol=1e-3)
    np.testing.assert_allclose(ydd[late], 0.0, atol=0.2)


def test_a_constant_is_there_at_once() -> None:
    low_pass = CausalFilter(3, 25.0)
    low_pass.start(np.array([2.0, -1.0]))
    low_pass.take(0.002, np.array([2.0, -1.0]))
    y, yd, ydd = low_pass.output()
    np.testing.assert_allclose(y, [2.0, -1.0], rtol=1e-12)
    np.testing.assert_allclose([yd, ydd], 0.0, atol=1e-6)


def test_what_was_before_is_forgotten_when_it_has_settled() -> None:
    low_pass = CausalFilter(3, 25.0)
    low_pass.start(np.array([0.0]))
    elapsed = 0.0
    while elapsed < low_pass.settled:
        low_pass.take(0.002, np.array([1.0]))
        elapsed += 0.002
    assert low_pass.output()[0][0] == pytest.approx(1.0, abs=2e-3)


START = 1_700_000_000_000_000_000  # ns


def views(
    time: Floats, names: tuple[str, ...] = JOINTS, scale: float = 1.0, late: float = 0.0
) -> list[JointStateView]:
    """Return the motion of the small model as messages; names may stand in any order."""
    q, _, _ = motion_at(time)
    tau = torque_of(*motion_at(time - late)) / scale
    columns = [JOINTS.index(name) if name in JOINTS else 0 for name in names]
    return [
        JointStateView(
            START + round(t * 1e9), names, position[columns], np.empty(0), effort[columns]
        )
        for t, position, effort in zip(time, q, tau, strict=True)
    ]


def taken(live: LiveStates, messages: list[JointStateView]) -> list[State]:
    states = [live.take(message, 0) for message in messages]
    return [state for state in states if state is not None]


@pytest.mark.parametrize("late", [0.0, 0.008])
def test_states_are_those_of_a_recording_of_the_same_messages(late: float) -> None:
    time = np.arange(0.0, 4.0, 0.002)
    q, qd, qdd = motion_at(time)
    motion = condition(Recording(JOINTS, time, q, qd, torque_of(q, qd, qdd)))
    live = LiveStates(JOINTS, Conditioning(effort_delay=late), 100.0)
    messages = views(time, late=late)
    states = [s for s in taken(live, messages) if s.at >= START + 1_000_000_000]
    at = np.array([(state.at - START) / 1e9 for state in states])
    assert np.median(np.diff(at)) == pytest.approx(0.01, abs=1e-6)
    assert live.delay == pytest.approx(4.0 / (2.0 * np.pi * 25.0), rel=1e-6)
    inside = (at > motion.time[0]) & (at < motion.time[-1])
    for name, tolerance in (("q", 1e-4), ("qd", 2e-3), ("qdd", 0.05), ("tau", 0.2)):
        offline = getattr(motion, name)
        for joint in range(2):
            expected = np.interp(at[inside], motion.time, offline[:, joint])
            mine = np.array([getattr(state, name)[joint] for state in states])[inside]
            assert np.sqrt(np.mean((mine - expected) ** 2)) < tolerance


def test_order_and_further_joints_do_not_matter() -> None:
    time = np.arange(0.0, 1.0, 0.004)
    plain = taken(LiveStates(JOINTS, Conditioning(), 50.0), views(time))
    live = LiveStates(JOINTS, Conditioning(effort_scale={"a": 2.0, "b": 2.0}), 50.0)
    other = taken(live, views(time, ("b", "gripper", "a"), scale=2.0))
    assert len(plain) > 20
    for one, two in zip(plain, other, strict=True):
        np.testing.assert_allclose(one.q, two.q)
        np.testing.assert_allclose(one.tau, two.tau)


def test_another_part_of_the_robot_is_not_a_mistake() -> None:
    live = LiveStates(JOINTS, Conditioning(), 50.0)
    view = JointStateView(START, ("gripper",), np.zeros(1), np.empty(0), np.zeros(1))
    assert live.take(view, 0) is None


@pytest.mark.parametrize(
    ("names", "position", "effort", "expected"),
    [
        (("a",), [0.0], [0.0], "joint states without b"),
        (("a", "b"), [0.0, 0.0], [], "without effort"),
        (("a", "b"), [], [0.0, 0.0], "without positions"),
        (("a", "b"), [0.0, np.nan], [0.0, 0.0], "the position of b is nan"),
        (("a", "b"), [0.0, 0.0], [np.inf, 0.0], "the effort of a is inf"),
        (("a", "b"), [1e308, 0.0], [0.0, 0.0], r"the position of a is 1e\+308"),
    ],
)
def test_what_cannot_be_used_is_said(
    names: tuple[str, ...], position: list[float], effort: list[float], expected: str
) -> None:
    view = JointStateView(START, names, np.array(position), np.empty(0), np.array(effort))
    with pytest.raises(MessageError, match=expected):
        LiveStates(JOINTS, Conditioning(), 50.0).take(view, 0)


def test_nothing_comes_until_the_rate_is_known_and_the_filter_has_settled() -> None:
    time = np.arange(0.0, 1.0, 0.002)
    states = taken(live := LiveStates(JOINTS, Conditioning(), 100.0), views(time))
    first = (states[0].at - START) / 1e9 + live.delay
    assert MEASURED * 0.002 + 0.1 < first < 0.4


def test_a_rate_that_was_measured_wrongly_is_measured_anew() -> None:
    live = LiveStates(JOINTS, Conditioning(), 100.0)
    random = np.random.default_rng(0)
    taken(live, views(np.cumsum(random.choice([0.3, 1e4, -1e4], 200))))
    assert live.period != pytest.approx(0.002)
    assert len(taken(live, views(np.arange(0.0, 2.0, 0.002)))) > 100
    assert live.period == pytest.approx(0.002)


def test_an_interruption_begins_a_new_segment() -> None:
    time = np.arange(0.0, 2.0, 0.002)
    messages = [m for m, t in zip(views(time), time, strict=True) if not 1.0 <= t < 1.1]
    live = LiveStates(JOINTS, Conditioning(), 100.0)
    states = taken(live, messages)
    assert live.gaps == 1
    before = [state.at for state in states if state.segment == 1]
    after = [state.at for state in states if state.segment == 2]
    assert max(before) <= START + 1_000_000_000
    assert min(after) > START + 1_200_000_000


def test_states_that_bridge_a_hole_say_so_until_the_filter_has_settled() -> None:
    time = np.arange(0.0, 3.0, 0.002)
    hole = (time > 1.5) & (time < 1.514)
    live = LiveStates(JOINTS, Conditioning(bandwidth=25.0), 100.0)
    states = taken(live, views(time[~hole]))
    bridged = [state.at / 1e9 - START / 1e9 for state in states if state.bridged]
    assert live.gaps == 0
    assert min(bridged) == pytest.approx(1.514 - live.delay, abs=0.011)
    assert max(bridged) - min(bridged) == pytest.approx(CausalFilter(3, 25.0).settled, abs=0.011)
    one = ~np.isin(np.arange(len(time)), [700, 800, 900])  # a lost sample is no hole
    assert not any(
        state.bridged
        for state in taken(
            LiveStates(JOINTS, Conditioning(bandwidth=25.0), 100.0), views(time[one])
        )
    )


def test_a_hole_is_forgotten_when_the_clock_is_set_back() -> None:
    time = np.arange(0.0, 3.0, 0.002)
    live = LiveStates(JOINTS, Conditioning(bandwidth=25.0), 100.0)
    taken(live, views(time[(time < 2.8) | (time > 2.814)]))
    again = taken(live, views(time))
    assert len(again) > 200
    assert not any(state.bridged for state in again)


def test_late_and_repeated_messages_are_left_out_and_a_clock_set_back_begins_again() -> None:
    messages = views(np.arange(0.0, 1.0, 0.002))
    live = LiveStates(JOINTS, Conditioning(), 100.0)
    taken(live, messages)
    for old in (messages[-1], messages[-3]):
        with pytest.raises(MessageError, match="not newer"):
            live.take(old, 0)
    assert live.gaps == 0
    earlier = views(np.arange(-100.0, -99.0, 0.002))
    assert taken(live, earlier)
    assert live.gaps == 1


def test_messages_without_a_stamp_have_the_time_they_came() -> None:
    live = LiveStates(JOINTS, Conditioning(), 100.0)
    time = np.arange(0.0, 1.0, 0.002)
    states = [
        live.take(
            JointStateView(0, view.names, view.position, view.velocity, view.effort), view.stamp
        )
        for view in views(time)
    ]
    assert any(state is not None and state.at > START for state in states)


def test_slow_messages_get_a_lower_bandwidth() -> None:
    live = LiveStates(JOINTS, Conditioning(), 100.0)
    states = taken(live, views(np.arange(0.0, 4.0, 0.02)))
    assert live.bandwidth == pytest.approx(12.5)
    assert np.diff([state.at for state in states]).min() >= 20_000_000
