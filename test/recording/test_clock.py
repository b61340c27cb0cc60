"""Logs with a faulty clock: the motion must come out nearly as well as with true stamps."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lagrangian_ff.recording import Conditioning, Motion, Recording, condition
from lagrangian_ff.recording.clock import retime

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

PERIOD = 1e-3
SECONDS = 6.0
EVEN: Floats = PERIOD * np.arange(int(SECONDS / PERIOD), dtype=np.float64)
STEP = 2e-5  # rad, of the encoder


class Truth:
    """An exciting trajectory: ten harmonics of 0.1 Hz on each of some joints."""

    def __init__(self, seed: int, joints: int = 3) -> None:
        generator = np.random.default_rng(seed)
        self.omega = 2 * np.pi * 0.1 * np.arange(1, 11)
        size = 0.5 / np.arange(1, 11)[:, np.newaxis]
        self.cosine, self.sine = generator.normal(size=(2, 10, joints)) * size

    def at(self, time: Floats, derivative: int = 0) -> Floats:
        """Position or a derivative of it, (M, N)."""
        angle = np.outer(time, self.omega) + derivative * np.pi / 2
        scale = self.omega**derivative
        return np.asarray(
            (np.cos(angle) * scale) @ self.cosine + (np.sin(angle) * scale) @ self.sine
        )

    def recorded(self, sampled: Floats, stamped: Floats) -> Recording:
        """The log of a driver that sampled at one time and stamped at another."""
        position = STEP * np.round(self.at(sampled) / STEP)
        effort = self.at(sampled, 2) + 3.0 * self.at(sampled)
        effort += 0.02 * np.random.default_rng(1).normal(size=effort.shape)
        names = tuple(f"joint_{k + 1}" for k in range(position.shape[1]))
        return Recording(names, stamped, position, np.full_like(position, np.nan), effort)


@dataclass(frozen=True)
class Log:
    """When samples were taken, how they were stamped, and in what order the rows came."""

    sampled: Floats
    stamped: Floats
    rows: Rows | None = None


def errors(motion: Motion, truth: Truth, away: float = 0.0) -> Floats:
    """Root mean square error of q, qd and qdd, after the best shift of time of each segment."""
    squares = np.zeros(3)
    for number in np.unique(motion.segment):
        part = motion.take(motion.segment == number)
        # Where a clock stepped, the time of a segment is known to some seconds.
        coarse = np.arange(-away, away + 0.01, 0.02)
        miss = [np.sum((truth.at(part.time[::40] + by) - part.q[::40]) ** 2) for by in coarse]
        time = part.time + coarse[int(np.argmin(miss))]
        for _ in range(6):
            speed = truth.at(time, 1)
            time = time + np.sum((part.q - truth.at(time)) * speed) / np.sum(speed**2)
        for k, found in enumerate((part.q, part.qd, part.qdd)):
            squares[k] += np.sum((found - truth.at(time, k)) ** 2)
    return np.asarray(np.sqrt(squares / motion.q.size))


def assert_as_good(log: Log, seed: int, most: float = 1.1, away: float = 0.0) -> Motion:
    """The motion is as good as with true stamps, but for the factor; return it."""
    truth = Truth(seed)
    known = condition(truth.recorded(log.sampled, log.sampled), Conditioning(clock="stamps"))
    recording = truth.recorded(log.sampled, log.stamped)
    if log.rows is not None:
        names = ("time", "position", "velocity", "effort")
        recording = replace(recording, **{n: getattr(recording, n)[log.rows] for n in names})
    found = condition(recording)
    least = np.array([STEP / 5, 0.0, 0.0])  # a fifth of an encoder's step is no error
    ratio = errors(found, truth, away) / np.maximum(errors(known, truth), least)
    assert (ratio <= most).all(), (ratio, found.notes)
    return found


def kept(generator: np.random.Generator, share: float, burst: int) -> NDArray[np.bool_]:
    """Which samples are left when a share of them is lost, `burst` at once on average."""
    keep = np.ones(len(EVEN), dtype=bool)
    for at in generator.integers(0, len(EVEN), int(len(EVEN) * share / burst)):
        keep[at : at + generator.integers(1, 2 * burst)] = False
    return keep


def said(motion: Motion, words: str) -> list[str]:
    return [note for note in motion.notes if words in note]


@pytest.mark.parametrize("burst", [1, 8])
@pytest.mark.parametrize("share", [0.001, 0.01, 0.1, 0.3])
def test_lost_samples_leave_right_stamps_alone(share: float, burst: int) -> None:
    generator = np.random.default_rng(int(1000 * share) + burst)
    sampled = EVEN[kept(generator, share, burst)]
    motion = assert_as_good(Log(sampled, sampled), 1, most=1.0 + 1e-9)
    assert not said(motion, "moved")


LATE: dict[str, Callable[[np.random.Generator, float, int], Floats]] = {
    "a queue": lambda generator, size, count: generator.exponential(size, count),
    "evenly": lambda generator, size, count: generator.uniform(0, size, count),
    "both ways": lambda generator, size, count: generator.normal(0, size, count),
}


@pytest.mark.parametrize("kind", LATE)
@pytest.mark.parametrize("size", [1e-5, 1e-4, 1e-3, 5e-3])
def test_late_stamps_are_moved_to_the_ticks(kind: str, size: float) -> None:
    stamped = EVEN + LATE[kind](np.random.default_rng(int(1e6 * size)), size, len(EVEN))
    if kind == "a queue":
        stamped = np.maximum.accumulate(stamped)
    motion = assert_as_good(Log(EVEN, stamped), 2)
    assert len(said(motion, "to the ticks of a steady clock")) == 1


@pytest.mark.parametrize(
    ("share", "burst", "size"), [(0.05, 1, 1e-5), (0.1, 8, 1e-4), (0.3, 1, 3e-4), (0.05, 1, 1e-3)]
)
def test_late_stamps_are_moved_where_samples_were_lost_too(
    share: float, burst: int, size: float
) -> None:
    generator = np.random.default_rng(int(1e6 * size) + burst)
    sampled = EVEN[kept(generator, share, burst)]
    late = np.maximum.accumulate(sampled + generator.exponential(size, len(sampled)))
    assert_as_good(Log(sampled, late), 3)


@pytest.mark.parametrize("size", [1e-5, 1e-4, 1e-3])
def test_samples_that_were_taken_unevenly_keep_their_stamps(size: float) -> None:
    generator = np.random.default_rng(4)
    sampled = np.sort(EVEN + generator.uniform(-size / 2, size / 2, len(EVEN)))
    motion = assert_as_good(Log(sampled, sampled), 4, most=1.0 + 1e-9)
    assert not said(motion, "moved")


@pytest.mark.parametrize(
    ("size", "random", "spread"),
    [(2, False, 0.0), (10, False, 2e-5), (30, False, 0.0), (4, True, 2e-5), (10, True, 0.0)],
)
def test_batches_stamped_together_are_spread(size: int, random: bool, spread: float) -> None:
    generator = np.random.default_rng(size)
    sizes = generator.integers(1, 2 * size, len(EVEN)) if random else np.full(len(EVEN), size)
    ends = np.minimum(np.cumsum(sizes), len(EVEN))
    last = ends[np.searchsorted(ends, np.arange(len(EVEN)), side="right")] - 1
    stamped = EVEN[last] - spread * (last - np.arange(len(EVEN)))
    motion = assert_as_good(Log(EVEN, stamped), 5)
    assert said(motion, "moved")
    assert not said(motion, "repeated")


def test_messages_sent_twice_are_left_out() -> None:
    generator = np.random.default_rng(6)
    again = generator.integers(0, len(EVEN), 400)
    for rows in (np.sort(np.concatenate([np.arange(len(EVEN)), again])),
                 np.concatenate([np.arange(len(EVEN)), again])):  # fmt: skip
        motion = assert_as_good(Log(EVEN, EVEN, rows), 6, most=1.0 + 1e-9)
        assert said(motion, "repeated by 400 samples")


def test_messages_out_of_order_are_sorted() -> None:
    generator = np.random.default_rng(7)
    rows = np.argsort(np.arange(len(EVEN)) + generator.uniform(0, 3, len(EVEN)))
    assert_as_good(Log(EVEN, EVEN, rows), 7, most=1.0 + 1e-9)


@pytest.mark.parametrize("late", [0.0, 5e-5])
@pytest.mark.parametrize("rates", [(125, 500), (500, 125), (1000, 400), (333, 100)])
def test_two_rates_one_after_the_other(rates: tuple[int, int], late: float) -> None:
    one, two = (np.arange(0, SECONDS / 2, 1 / rate) for rate in rates)
    sampled = np.concatenate([one, SECONDS / 2 + two])
    stamped = sampled + np.random.default_rng(8).exponential(late, len(sampled))
    assert_as_good(Log(sampled, stamped), 8)


@pytest.mark.parametrize("late", [0.0, 1e-4])
@pytest.mark.parametrize("size", [0.01, -0.01, -0.1, 0.5, 10.0, -10.0])
def test_a_clock_that_steps_while_the_arm_moves(size: float, late: float) -> None:
    at = 3712
    stamped = EVEN + np.random.default_rng(9).exponential(late, len(EVEN))
    stamped[at:] += size
    motion = assert_as_good(Log(EVEN, stamped), 9)
    assert np.unique(motion.segment).size == 1
    (note,) = said(motion, "stepped")
    assert float(note.split(" by ")[1].split(" s")[0]) == pytest.approx(abs(size), abs=1e-3)
    assert ("forward" if size > 0 else "back") in note


@pytest.mark.parametrize("size", [0.01, 0.1, 1.0])
def test_a_pause_while_the_arm_moves_is_no_step_of_the_clock(size: float) -> None:
    sampled = np.delete(EVEN, np.arange(3712, 3712 + round(size / PERIOD)))
    motion = assert_as_good(Log(sampled, sampled), 10, most=1.0 + 1e-9)
    assert not said(motion, "stepped")
    assert not said(motion, "moved")


def coarsely(time: Floats, position: Floats, step: float) -> Recording:
    """Return a log of an encoder's steps, of joints that need no torque."""
    position = step * np.round(position / step)
    unknown, nothing = np.full_like(position, np.nan), np.zeros_like(position)
    return Recording(("a", "b", "c")[: position.shape[1]], time, position, unknown, nothing)


@pytest.mark.parametrize("first", range(4))
@pytest.mark.parametrize("hertz", [2.0, 7.7])
def test_a_pause_in_a_fast_motion_is_no_step_of_the_clock(hertz: float, first: int) -> None:
    time = np.arange(1500) / 126.0
    kept = np.ones(len(time), dtype=np.bool_)
    for begin in range(50 + first, 1450, 51):
        kept[begin : begin + 3] = False
    time = time[kept]
    angle = 2.0 * np.pi * hertz * np.outer(time, [1.0, 0.87]) + np.array([0.0, 1.0])
    notes: list[str] = []
    recording = coarsely(time, 0.04 * np.sin(angle), 2e-4)
    assert np.array_equal(retime(recording, "auto", notes), time)
    assert not notes


@pytest.mark.parametrize("lost", [11, 13])
def test_a_pause_in_an_even_motion_is_no_step_of_the_clock(lost: int) -> None:
    time = np.arange(1500) / 120.0
    time = np.concatenate([time[:700], time[700 + lost :]])
    position = np.outer(time, [5e-3, 1e-3, 5e-4])
    notes: list[str] = []
    assert np.array_equal(retime(coarsely(time, position, 3e-5), "auto", notes), time)
    assert not notes


def test_a_joint_slower_than_its_encoder_resolves_is_sampled_all_the_same() -> None:
    time = np.arange(1000) / 50.0
    stamped = time + np.random.default_rng(17).exponential(2e-3, len(time))
    recording = coarsely(stamped, np.outer(time, [2e-3]), 1.2e-4)
    found = retime(recording, "auto", [])
    assert np.std(found - time) < 1.1 * np.std(stamped - time)


def test_a_clock_that_was_set_back_at_rest_keeps_the_pieces_apart() -> None:
    truth = Truth(11)
    moving = np.where(EVEN < 4.0, EVEN, np.maximum(4.0, EVEN - 0.5))  # half a second of rest
    stamped = EVEN.copy()
    stamped[4200:] -= 0.3
    motion = condition(truth.recorded(moving, stamped))
    assert np.unique(motion.segment).size == 2
    assert said(motion, "set back by 0.299 s after 4.199 s")


def moved_times(log: Log, truth: Truth, clock: str = "auto") -> tuple[Floats, list[str]]:
    """The repaired times of a log's samples, and the notes."""
    notes: list[str] = []
    return retime(truth.recorded(log.sampled, log.stamped), clock, notes), notes


@settings(max_examples=15, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.integers(1, 2998), max_size=20, unique=True),
    st.lists(st.tuples(st.integers(1, 2900), st.integers(2, 40)), max_size=3),
    st.floats(-1e-4, 1e-4),
)
def test_ticks_are_found_through_losses_and_drift(
    seed: int, lost: list[int], bursts: list[tuple[int, int]], drift: float
) -> None:
    away = np.zeros(3000, dtype=bool)
    away[lost] = True
    for at, count in bursts:
        away[at : at + count] = True
    sampled: Floats = 4e-3 * (1 + drift) * np.arange(3000, dtype=np.float64)[~away]
    generator = np.random.default_rng(seed)
    # Mostly tens of microseconds, now and then more than a millisecond.
    rare = generator.random(len(sampled)) < 0.01
    late = generator.exponential(3e-5, len(sampled))
    late += rare * generator.uniform(5e-4, 2e-3, len(sampled))
    found, notes = moved_times(Log(sampled, sampled + late), Truth(seed % 100))
    # Either the ticks, or, where the motion does not show them, the stamps as they are.
    if notes:
        assert np.ptp(found - sampled) < 1e-5
    else:
        assert np.array_equal(found, sampled + late)


@settings(max_examples=15, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from([0.0, 1e-5, 1e-4, 4e-4]),
    st.floats(0.0, 0.4),
    st.sampled_from(["auto", "stamps"]),
)
def test_right_stamps_are_never_moved(seed: int, uneven: float, share: float, clock: str) -> None:
    generator = np.random.default_rng(seed)
    sampled = np.sort(EVEN[:3000] + generator.uniform(-uneven, uneven, 3000))
    sampled = sampled[generator.random(3000) >= share]
    found, notes = moved_times(Log(sampled, sampled), Truth(seed % 100), clock)
    assert np.array_equal(found, sampled)
    assert not notes


def test_at_rest_nothing_shows_and_stamps_are_kept() -> None:
    stamped = EVEN + np.random.default_rng(12).exponential(2e-4, len(EVEN))
    found, notes = moved_times(Log(np.zeros(len(EVEN)), stamped), Truth(12))
    assert np.array_equal(found, stamped)
    assert not notes


@pytest.mark.parametrize("rest", [0.0, 0.3])
def test_where_a_slow_motion_has_edges_the_stamps_count_the_ticks(rest: float) -> None:
    time = PERIOD * np.arange(8000)
    part = (time / 3.0) % 1.0  # to and fro at one speed, with rests
    speed = np.where(part < 0.5, 0.02, -0.02) * (part % 0.5 >= 0.5 * rest)
    position = np.zeros((len(time), 3))
    position[:, 1] = STEP * np.round(np.cumsum(speed) * PERIOD / STEP)
    generator = np.random.default_rng(16)
    order = 1e-6 * np.arange(len(time))
    late = time + 0.1 * PERIOD * generator.exponential(size=len(time)) - order
    stamped = np.maximum.accumulate(late) + order
    unknown, effort = np.full_like(position, np.nan), generator.normal(size=position.shape)
    recording = Recording(("a", "b", "c"), stamped, position, unknown, effort)
    found = retime(recording, "auto", [])
    assert np.std(found - time) < 0.01 * np.std(stamped - time)


def test_a_steady_clock_can_be_asked_for() -> None:
    stamped = EVEN + np.random.default_rng(13).exponential(5e-5, len(EVEN))
    found, (note,) = moved_times(Log(stamped, stamped), Truth(13), "steady")
    assert np.ptp(found - EVEN) < 1e-5
    assert "as the setting of the clock says" in note


def test_no_sample_is_moved_over_a_gap() -> None:
    left = np.delete(EVEN, np.arange(3000, 3700))
    late = left + np.random.default_rng(14).exponential(2e-4, len(left))
    found, _ = moved_times(Log(left, late), Truth(14))
    assert found[3000] - found[2999] == pytest.approx(0.701, abs=1e-5)
    assert np.abs(found - late).max() < 3e-3


def test_each_publisher_has_its_own_clock() -> None:
    sampled = EVEN[:3000]
    late = np.maximum.accumulate(sampled + np.random.default_rng(15).exponential(2e-4, 3000))
    one, two = Truth(15, 2).recorded(sampled, late), Truth(16, 2).recorded(sampled, sampled + 4e-4)
    nothing = np.full((3000, 2), np.nan)
    rows = np.argsort(np.concatenate([one.time, two.time]), kind="stable")
    together = Recording(
        ("a", "b", "c", "d"),
        np.concatenate([one.time, two.time])[rows],
        np.block([[one.position, nothing], [nothing, two.position]])[rows],
        np.full((6000, 4), np.nan),
        np.block([[one.effort, nothing], [nothing, two.effort]])[rows],
    )
    notes: list[str] = []
    found = retime(together, "auto", notes)
    assert len(notes) == 1
    assert np.abs(found[rows < 3000] - np.sort(sampled)).max() < 1e-5
    assert np.array_equal(found[rows >= 3000], two.time)
