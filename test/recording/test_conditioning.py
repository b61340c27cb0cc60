"""From recordings to motion: exactness, repairs, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recording_examples import Floats, swinging

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording import Conditioning, Motion, Recording, condition

BASE = swinging(1500)


def taken(recording: Recording, rows: object) -> Recording:
    """The recording with these rows, in this order."""
    index = np.arange(len(recording))[rows]  # type: ignore[call-overload]
    names = ("time", "position", "velocity", "effort")
    return replace(recording, **{name: getattr(recording, name)[index] for name in names})


def sine(frequency: float, rate: float = 500.0, seconds: float = 4.0) -> Recording:
    """One joint: sin(2π f t), effort equal to its acceleration divided by (2π f)²."""
    time = np.arange(int(seconds * rate), dtype=np.float64) / rate
    wave: Floats = np.sin(2 * np.pi * frequency * time)[:, np.newaxis]
    return Recording(("a",), time, wave, np.full_like(wave, np.nan), -wave)


def gain(frequency: float, rate: float = 500.0, bandwidth: float = 25.0) -> float:
    ratio = np.tan(np.pi * frequency / rate) / np.tan(np.pi * bandwidth / rate)
    return float(1 / (1 + ratio**6))


def assert_close(found: Motion, expected: Motion, tolerance: float) -> None:
    assert np.allclose(found.time, expected.time, atol=1e-9)
    for name in ("q", "qd", "qdd", "tau"):
        scale = np.abs(getattr(expected, name)).max()
        assert np.allclose(getattr(found, name), getattr(expected, name), atol=tolerance * scale), (
            name
        )


@pytest.mark.parametrize("frequency", [0.2, 1.0, 3.0, 5.0])
def test_sines_come_out_with_their_derivatives_and_in_step(frequency: float) -> None:
    motion = condition(sine(frequency))
    omega = 2 * np.pi * frequency
    kept = gain(frequency)
    time = motion.time
    assert np.allclose(motion.q[:, 0], kept * np.sin(omega * time), atol=2e-5)
    assert np.allclose(motion.qd[:, 0] / omega, kept * np.cos(omega * time), atol=2e-4)
    # At the very ends a thousandth of what the filter had to guess remains.
    assert np.allclose(motion.qdd[:, 0] / omega**2, -kept * np.sin(omega * time), atol=2e-3)
    assert np.allclose(motion.tau[:, 0], motion.qdd[:, 0] / omega**2, atol=2e-3)
    assert np.allclose(motion.qdd[50:-50, 0] / omega**2, motion.tau[50:-50, 0], atol=1e-5)


def test_noise_on_position_and_torque_is_reduced_alike() -> None:
    noise = np.random.default_rng(1).normal(size=(20_000, 1))
    time = 0.002 * np.arange(20_000, dtype=np.float64)
    recording = Recording(("a",), time, noise, noise, noise)
    motion = condition(recording)
    assert np.array_equal(motion.q, motion.tau)
    assert 0.2 < motion.q.std() < 0.33  # about sqrt(25 Hz / 250 Hz)


def test_a_clean_clock_keeps_its_samples_and_stamps() -> None:
    motion = condition(BASE)
    assert np.allclose(motion.time, BASE.time[44:-44], atol=1e-12)
    assert not any("resampled" in note or "interpolated" in note for note in motion.notes)
    assert motion.source == BASE.source


@settings(max_examples=20, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.integers(0, 1499), max_size=9),  # ten in order are a clock set back
    st.sampled_from([3, 50, 1500]),
)
def test_shuffled_and_repeated_stamps_give_the_same_motion(
    seed: int, repeats: list[int], reach: int
) -> None:
    generator = np.random.default_rng(seed)
    rows = np.argsort(np.arange(1500) + generator.uniform(0, reach, 1500))
    dirty = taken(BASE, np.concatenate([rows, np.array(repeats, dtype=int)]))
    assert_close(condition(dirty), condition(BASE), 1e-12)
    notes = " ".join(condition(dirty).notes)
    if repeats:
        assert "stamps repeated by" in notes
    if (np.diff(rows) < 0).any():
        assert "out of order" in notes


@settings(max_examples=10, deadline=None)
@given(st.permutations(BASE.joints))
def test_the_order_of_joints_does_not_matter(joints: list[str]) -> None:
    turned = condition(BASE.select(tuple(joints))).select(BASE.joints)
    assert_close(turned, condition(BASE), 0.0)


def test_jittering_stamps_are_put_on_a_uniform_clock() -> None:
    generator = np.random.default_rng(2)
    time = BASE.time + generator.uniform(-4e-4, 4e-4, len(BASE))
    omega: Floats = 2 * np.pi * (0.5 + 0.3 * np.arange(3, dtype=np.float64))
    angle = np.outer(time, omega)
    jittered = replace(BASE, time=time, position=np.sin(angle), effort=3 - omega**2 * np.sin(angle))
    motion = condition(jittered)
    assert np.allclose(np.diff(motion.time), np.diff(motion.time)[0])
    inside = slice(50, -50)
    expected = -(omega**2) * np.sin(np.outer(motion.time, omega))
    assert np.allclose(motion.qdd[inside], expected[inside], atol=0.02)
    assert np.allclose(motion.tau[inside] - 3, expected[inside], atol=0.01)
    assert any("resampled" in note for note in motion.notes)


def test_short_gaps_are_bridged_and_long_ones_separate_segments() -> None:
    kept = np.ones(1500, dtype=bool)
    kept[300:305] = False
    kept[800:900] = False
    motion = condition(taken(BASE, kept))
    assert np.array_equal(np.unique(motion.segment), [0, 1])
    assert motion.time[motion.segment == 0].max() < BASE.time[800]
    assert motion.time[motion.segment == 1].min() > BASE.time[899]
    whole = condition(BASE)
    shared = np.isin(np.round(whole.time, 6), np.round(motion.time[motion.segment == 0], 6))
    near = slice(0, -60)  # away from the new end
    found = motion.qdd[motion.segment == 0]
    assert np.allclose(found[near], whole.qdd[shared][near], atol=0.02)
    notes = " ".join(motion.notes)
    assert "1 gap longer than 20 ms; 2 segments" in notes
    assert "interpolated 5 lost samples in short gaps (up to 12 ms)" in notes


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("rate", [200.0, 1000.0, 3000.0])
def test_what_is_bridged_is_as_sure_as_the_samples(rate: float, seed: int) -> None:
    """Of torque that is noise, hardly more is left where neighbours were lost together."""
    generator = np.random.default_rng(seed)
    moving = sine(0.5, rate=rate, seconds=12.0)
    noisy = replace(moving, effort=generator.normal(size=(len(moving), 1)))
    kept = np.ones(len(moving), dtype=bool)
    for start in generator.integers(0, len(moving) - 100, 36):
        kept[start : start + generator.integers(1, int(0.018 * rate))] = False
    same = Conditioning(bandwidth=25.0)
    whole, bridged = condition(noisy, same), condition(taken(noisy, kept), same)
    assert len(bridged) > 0.95 * len(whole)
    assert np.std(bridged.tau) < 1.5 * np.std(whole.tau)
    assert np.abs(bridged.tau).max() < np.abs(noisy.effort).max()
    inside = bridged.time < whole.time[-1]
    expected = np.interp(bridged.time, whole.time, whole.q[:, 0])
    assert np.allclose(bridged.q[inside, 0], expected[inside], atol=1e-4)


def test_a_stretch_too_short_between_gaps_is_left_out() -> None:
    kept = np.ones(1500, dtype=bool)
    kept[700:800] = kept[830:900] = False
    motion = condition(taken(BASE, kept))
    assert np.array_equal(np.unique(motion.segment), [0, 1])
    assert any("left out 1 piece" in note and "(30 samples)" in note for note in motion.notes)


def test_single_nan_are_bridged_and_told() -> None:
    position, effort = BASE.position.copy(), BASE.effort.copy()
    position[400, 1] = np.nan
    effort[500:503, 2] = np.nan
    motion = condition(replace(BASE, position=position, effort=effort))
    whole = condition(BASE)
    assert_close(motion, whole, 1e-3)
    assert "elbow: no position in 1 of 1500 samples, first at 0.800 s; left out" in motion.notes
    assert "wrist: no effort in 3 of 1500 samples, first at 1.000 s; left out" in motion.notes


def test_nan_for_long_ends_a_segment() -> None:
    effort = BASE.effort.copy()
    effort[700:900, 0] = np.nan
    motion = condition(replace(BASE, effort=effort))
    assert np.array_equal(np.unique(motion.segment), [0, 1])
    assert np.isfinite(motion.tau).all()
    inside = (motion.time > BASE.time[699]) & (motion.time < BASE.time[900])
    assert not inside.any()


def test_publishers_that_take_turns_are_brought_onto_one_clock() -> None:
    time: Floats = np.arange(3000, dtype=np.float64) * 0.001
    omega = np.array([2.0, 3.0])
    position = np.sin(np.outer(time, omega))
    effort = -position
    for column in (0, 1):
        position[column::2, column] = effort[column::2, column] = np.nan
    missing = np.full_like(position, np.nan)
    motion = condition(Recording(("a", "b"), time, position, missing, effort))
    assert np.allclose(np.diff(motion.time), 0.002)
    inside = slice(50, -50)
    expected = np.cos(np.outer(motion.time, omega)) * omega
    assert np.allclose(motion.qd[inside], expected[inside], atol=1e-3)


def test_a_clock_set_back_separates_what_would_be_mixed() -> None:
    restarted = taken(BASE, np.tile(np.arange(1500), 2))
    restarted = replace(restarted, position=np.concatenate([BASE.position, 2 * BASE.position]))
    motion = condition(restarted)
    whole = condition(BASE)
    assert np.array_equal(np.unique(motion.segment), [0, 1])
    assert np.allclose(motion.q[motion.segment == 0], whole.q)
    assert np.allclose(motion.q[motion.segment == 1], 2 * whole.q)
    assert (np.diff(motion.time) > 0).all()
    assert any("set back" in note for note in motion.notes)


def test_effort_is_scaled_and_shifted_by_joint() -> None:
    whole = condition(BASE)
    scaled = condition(
        BASE, Conditioning(effort_scale={"elbow": -2.0}, effort_offset={"elbow": 1.0, "wrist": 3.0})
    )
    assert np.allclose(scaled.tau, whole.tau * [1, -2, 1] + [0, 1, 3])
    assert np.array_equal(scaled.q, whole.q)
    with pytest.raises(RecordingError, match="effort_scale is given for tool, but the recording"):
        condition(BASE, Conditioning(effort_scale={"tool": 1.0}))


@pytest.mark.parametrize("late", [0.008, -0.005])
def test_a_late_effort_is_set_right(late: float) -> None:
    omega = 2 * np.pi * 2.0
    right = sine(2.0)
    wrong = replace(right, effort=-np.sin(omega * (right.time[:, None] - late)))
    whole, motion = condition(right), condition(wrong, Conditioning(effort_delay=late))
    assert np.allclose(motion.tau, whole.tau, atol=2e-4)
    assert np.array_equal(motion.q, whole.q)
    assert not np.allclose(condition(wrong).tau, whole.tau, atol=0.05)


def test_a_delay_that_no_driver_has_is_refused() -> None:
    with pytest.raises(RecordingError, match=r"effort_delay is 0\.2 s, expected at most 0\.05 s"):
        Conditioning(effort_delay=0.2)


@pytest.mark.parametrize("rate", [100.0, 125.0, 333.0, 1000.0])
def test_another_rate_resamples_the_same_motion(rate: float) -> None:
    whole = condition(BASE)
    motion = condition(BASE, Conditioning(rate=rate))
    assert np.allclose(np.diff(motion.time), 1 / rate)
    for name in ("q", "qd", "qdd", "tau"):
        for joint in range(3):
            expected = np.interp(motion.time, whole.time, getattr(whole, name)[:, joint])
            assert np.allclose(getattr(motion, name)[:, joint], expected, atol=5e-3)


def test_the_bandwidth_yields_to_a_low_rate() -> None:
    slow = sine(1.0, rate=40.0, seconds=20.0)
    motion = condition(slow, Conditioning(bandwidth=25.0))
    assert any("bandwidth reduced from 25 Hz to 10 Hz" in note for note in motion.notes)
    inside = slice(20, -20)
    expected = gain(1.0, 40.0, 10.0) * 2 * np.pi * np.cos(2 * np.pi * motion.time)
    assert np.allclose(motion.qd[inside, 0], expected[inside], atol=0.01)


def changed(**arrays: object) -> Recording:
    return replace(BASE, source="arm.mcap (/joint_states)", **arrays)  # type: ignore[arg-type]


def column(quantity: str, joint: int, value: float) -> dict[str, object]:
    table = getattr(BASE, quantity).copy()
    table[:, joint] = value
    return {quantity: table}


@pytest.mark.parametrize(
    ("recording", "message"),
    [
        (changed(**column("effort", 1, np.nan)), "no effort of elbow: empty or NaN in all 1500"),
        (changed(effort=np.full((1500, 3), np.nan)), "no effort of any joint"),
        (changed(**column("effort", 2, 0.0)), "the effort of wrist is 0 in all 1500"),
        (changed(effort=np.zeros((1500, 3))), "the effort of every joint is 0"),
        (changed(**column("position", 0, np.nan)), "no position of shoulder: NaN in all"),
        (changed(position=np.ones((1500, 3))), "no joint moves"),
        (taken(changed(), slice(0, 60)), "longest stretch without a gap of more than 20 ms lasts"),
        (taken(changed(), slice(0, 1)), "1 samples of 3 joints"),
        (changed(time=np.zeros(1500)), "all samples bear the same stamp, 0.000 s"),
        (changed(time=0.1 * np.arange(1500) ** 2), "Hz; expected at least 10 Hz"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_cannot_be_used_is_refused_with_the_place(recording: Recording, message: str) -> None:
    with pytest.raises(RecordingError) as caught:
        condition(recording)
    assert message in str(caught.value)
    assert "arm.mcap (/joint_states)" in str(caught.value)


def test_one_still_joint_is_only_noted() -> None:
    motion = condition(changed(**column("position", 0, 0.5)))
    assert any(note.startswith("shoulder stands still") for note in motion.notes)


@pytest.mark.parametrize(
    "wrong",
    [
        {"bandwidth": 0.0},
        {"bandwidth": float("nan")},
        {"rate": -1.0},
        {"max_gap": 0.0},
        {"trim": -0.1},
        {"order": 0},
        {"clock": "mine"},
        {"effort_scale": {"elbow": float("inf")}},
    ],
)
def test_impossible_settings_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(RecordingError, match=next(iter(wrong))):
        Conditioning(**wrong)  # type: ignore[arg-type]
