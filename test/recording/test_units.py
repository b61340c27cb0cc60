"""Units that an option names are converted; those that contradict are named, with the option."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording import Conditioning, Doubt, Recording, condition, converted, inspect

DEGREE = np.pi / 180.0


def arm(
    seconds: float = 20.0, rate: float = 250.0, noise: tuple[float, float] = (1e-5, 0.05)
) -> Recording:
    """Two joints that turn up to 1.5 rad, with gravity and friction, as a good driver reports.

    Args:
        noise: of the position, rad, and of the effort, N·m.
    """
    random = np.random.default_rng(0)
    time = np.arange(round(seconds * rate)) / rate
    angle = np.outer(time, 2 * np.pi * np.array([0.2, 0.33]))
    faster = np.outer(time, 2 * np.pi * np.array([0.71, 0.53]))
    q = np.sin(angle) + 0.4 * np.sin(faster)
    qd = np.gradient(q, time, axis=0, edge_order=2)
    qdd = np.gradient(qd, time, axis=0, edge_order=2)
    tau = np.array([20.0, 5.0]) * np.cos(q) + np.array([2.0, 0.5]) * (qdd + np.sign(qd))
    tau += noise[1] * random.standard_normal(q.shape)
    q = q + noise[0] * random.standard_normal(q.shape)
    return Recording(("base", "elbow"), time, q, qd, tau)


def doubts(recording: Recording) -> tuple[Doubt, ...]:
    return inspect(recording).doubts


def only(recording: Recording) -> Doubt:
    (doubt,) = doubts(recording)
    return doubt


def test_a_sound_recording_raises_no_doubt() -> None:
    assert doubts(arm()) == ()
    assert doubts(replace(arm(), velocity=np.full(arm().velocity.shape, np.nan))) == ()


def test_the_velocity_of_a_filter_or_of_an_encoder_raises_no_doubt() -> None:
    recording = arm()
    late = np.roll(recording.velocity, 5, axis=0)
    coarse = 0.02 * np.round(recording.velocity / 0.02)
    for velocity in (late, coarse):
        assert doubts(replace(recording, velocity=velocity)) == ()


def test_lost_samples_raise_no_doubt() -> None:
    recording = arm()
    kept = np.random.default_rng(1).random(len(recording)) > 0.2
    fields = {name: getattr(recording, name)[kept] for name in ("time", "position", "velocity")}
    assert doubts(replace(recording, effort=recording.effort[kept], **fields)) == ()


@pytest.mark.parametrize(("unit", "seconds"), [("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)])
@pytest.mark.parametrize("velocity", [True, False])
def test_stamps_of_another_unit(unit: str, seconds: float, velocity: bool) -> None:
    recording = arm()
    wrong = replace(recording, time=np.round(recording.time / seconds))
    if not velocity:
        wrong = replace(wrong, velocity=np.full(wrong.velocity.shape, np.nan))
    doubt = only(wrong)
    assert (doubt.quantity, doubt.remedy) == ("time", f"--units time={unit} reads them")
    with pytest.raises(RecordingError, match=f"sampled at .* Hz; expected .*--units time={unit}"):
        condition(wrong)
    motion = condition(wrong, Conditioning(bandwidth=25.0, units={"time": unit}))
    right = condition(recording, Conditioning(bandwidth=25.0))
    np.testing.assert_allclose(motion.qdd, right.qdd, atol=1e-6)
    assert any(f"time from {unit}" in note for note in motion.notes)


@pytest.mark.parametrize(
    ("factor", "words", "option"),
    [
        (1 / DEGREE, "it is in deg/s", "velocity=deg/s"),
        (60 / (2 * np.pi), "it is in rpm", "velocity=rpm"),
        (1e3, "it is in mrad/s", "velocity=mrad/s"),
        (DEGREE, "position is in deg", "position=deg"),
        (1.7, "velocity is 1.7 times the derivative of position", ""),
    ],
)
def test_velocity_in_another_unit(factor: float, words: str, option: str) -> None:
    recording = arm()
    doubt = only(replace(recording, velocity=factor * recording.velocity))
    assert words in doubt.text()
    assert option in doubt.remedy
    assert doubt.factor == pytest.approx(factor, rel=0.01)


def test_velocity_of_one_joint() -> None:
    recording = arm()
    turned = only(replace(recording, velocity=recording.velocity * [1.0, -1.0]))
    assert "velocity of elbow has the sign opposite" in turned.finding
    geared = only(replace(recording, velocity=recording.velocity * [50.0, 1.0]))
    assert (geared.joint, geared.factor) == ("base", pytest.approx(50.0, rel=0.01))
    swapped = doubts(replace(recording, velocity=recording.velocity[:, ::-1]))
    assert [one.joint for one in swapped] == ["base", "elbow"]
    assert "velocity of base is that of elbow" in swapped[0].finding
    noise = np.random.default_rng(2).standard_normal(len(recording))
    unrelated = np.stack([recording.velocity[:, 0], noise], axis=1)
    assert "does not follow" in only(replace(recording, velocity=unrelated)).finding


def test_degrees_in_position_and_velocity_are_seen_by_the_torque() -> None:
    recording = arm()
    degrees = replace(
        recording, position=recording.position / DEGREE, velocity=recording.velocity / DEGREE
    )
    doubt = only(degrees)
    assert (doubt.quantity, doubt.joint) == ("position", None)
    assert "--units position=deg" in doubt.remedy


def test_many_turns_are_no_degrees() -> None:
    """A joint that turns 8 times, whose torque follows its angle in rad."""
    recording = arm(seconds=40.0)
    turning = 25.0 * (1 - np.cos(2 * np.pi * recording.time / 40.0))
    position = np.stack([recording.position[:, 0], turning], axis=1)
    velocity = np.gradient(position, recording.time, axis=0)
    effort = recording.effort.copy()
    effort[:, 1] = 5.0 * np.cos(turning) + np.sign(velocity[:, 1])
    wide = replace(recording, position=position, velocity=velocity, effort=effort)
    assert doubts(wide) == ()


@pytest.mark.parametrize(
    ("noise", "doubted"),
    [((1e-4, 0.0), ["effort"]), ((1e-4, 0.01), []), ((0.0, 0.0), [])],
    ids=["commanded", "measured", "smoothed before it was recorded"],
)
def test_an_effort_without_the_noise_of_a_sensor_was_not_measured(
    noise: tuple[float, float], doubted: list[str]
) -> None:
    assert [one.quantity for one in doubts(arm(noise=noise))] == doubted


@pytest.mark.parametrize(
    ("units", "factors"),
    [
        ({"position": "deg", "velocity": "deg/s"}, (1.0, DEGREE, DEGREE, 1.0)),
        ({"effort": "mN·m"}, (1.0, 1.0, 1.0, 1e-3)),
        ({"time": "us", "effort": "lbf·in"}, (1e-6, 1.0, 1.0, 0.112985)),
    ],
)
def test_what_an_option_names_is_converted_and_noted(
    units: Mapping[str, str], factors: tuple[float, ...]
) -> None:
    recording = arm()
    found = converted(recording, Conditioning(units=units).units)
    for name, factor in zip(("time", "position", "velocity", "effort"), factors, strict=True):
        expected = factor * getattr(recording, name)
        np.testing.assert_allclose(getattr(found, name), expected, rtol=1e-5)
    assert "converted as asked" in found.notes[-1]
    assert converted(recording, {}) is recording


def test_units_stay_with_the_motion() -> None:
    settings = Conditioning(units={"effort": "mNm"})
    motion = condition(arm(), settings)
    kept = Conditioning.from_record(motion.conditioning)
    assert kept is not None
    assert kept.units == settings.units


@pytest.mark.parametrize(
    ("units", "words"),
    [
        ({"angle": "deg"}, "no quantity 'angle', expected time, position, velocity, effort"),
        ({"position": "grad"}, "position in 'grad', expected rad, deg, mrad"),
    ],
)
def test_unknown_units_are_refused(units: Mapping[str, str], words: str) -> None:
    with pytest.raises(RecordingError, match=words):
        Conditioning(units=units)
