"""What inspection finds, planted."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recording_examples import swinging

from lagrangian_ff.recording import Recording, inspect
from lagrangian_ff.recording.inspection import clipped, resolution

BASE = swinging(2000)
WAVE = np.sin(np.linspace(0, 20, 4000))


@given(st.floats(1e-5, 1e-2), st.floats(-3, 3))
def test_the_step_of_an_encoder_is_found(step: float, offset: float) -> None:
    position = offset + step * np.round(WAVE / step)
    assert resolution(position) == pytest.approx(step, rel=1e-4)


@given(st.integers(0, 1000))
def test_positions_without_a_step_have_none(seed: int) -> None:
    noise = np.random.default_rng(seed).normal(scale=1e-3, size=WAVE.size)
    assert resolution(WAVE + noise) is None


def test_a_fast_joint_that_skips_steps_still_shows_its_encoder() -> None:
    position = 1e-4 * np.round(np.sin(np.linspace(0, 200, 20_000)) / 1e-4)
    assert resolution(position) == pytest.approx(1e-4)


@pytest.mark.parametrize("values", [[], [1.0], [1.0, 1.0, 2.0], [np.nan, np.nan]])
def test_too_few_values_have_no_step(values: list[float]) -> None:
    assert resolution(np.array(values)) is None


@given(st.floats(0.5, 0.95))
def test_a_clipped_effort_is_found_with_its_share(limit: float) -> None:
    noise = np.random.default_rng(3).normal(scale=0.01, size=WAVE.size)
    effort = np.minimum(WAVE + noise, limit)
    ((value, share),) = clipped(effort)
    assert value == limit
    assert share == pytest.approx(np.mean(effort == limit))


def test_both_limits_are_found() -> None:
    assert [value for value, _ in clipped(np.clip(WAVE, -0.5, 0.7))] == [0.7, -0.5]


@pytest.mark.parametrize("step", [1e-6, 1e-3, 1e-2, 0.05])
def test_smooth_and_quantised_peaks_are_not_clipping(step: float) -> None:
    assert clipped(step * np.round(WAVE / step)) == []


def test_constant_effort_is_not_clipping() -> None:
    assert clipped(np.zeros(100)) == []
    assert clipped(np.full(100, np.nan)) == []


@pytest.mark.parametrize(
    ("step", "noise"),
    [(1e-3, 0.0), (1e-3, 1.0), (1e-2, 0.0), (1e-2, 0.3), (0.05, 0.3), (0.05, 1.0)],
)
def test_a_quantised_effort_is_clipped_where_it_rests_longest(step: float, noise: float) -> None:
    """Noise in steps. Round peaks rest on one step, too; a cut rests on it far longer."""
    random = np.random.default_rng(4)
    wave = np.sin(np.linspace(0, 60, 12_000)) + 0.4 * np.sin(np.linspace(0, 142, 12_000))
    effort = step * np.round((wave + noise * step * random.normal(size=wave.size)) / step)
    assert clipped(effort) == []
    ((value, _),) = clipped(np.minimum(effort, step * np.round(0.4 / step)))
    assert value == pytest.approx(0.4)


def test_an_effort_that_a_driver_repeats_is_not_clipped() -> None:
    assert clipped(np.repeat(WAVE, 4)) == []
    assert len(clipped(np.repeat(np.minimum(WAVE, 0.8), 4))) == 1


def test_an_arm_that_stands_still_is_not_clipped() -> None:
    """It rests at its largest torque; clipped is only what rests while the joint moves."""
    rest = np.concatenate([WAVE[:314], np.full(1000, 1.0), WAVE[314:]])
    moving = np.concatenate([np.ones(314, bool), np.zeros(1000, bool), np.ones(3686, bool)])
    assert len(clipped(rest)) == 1
    assert clipped(rest, moving) == []
    position = np.concatenate([BASE.position[:700], np.repeat(BASE.position[700:701], 600, 0)])
    effort = np.concatenate([BASE.effort[:700], np.full((600, 3), 50.0)])
    still = replace(
        BASE,
        time=BASE.time[:1300],
        position=position,
        velocity=np.full_like(position, np.nan),
        effort=effort,
    )
    assert inspect(still).clipping == ()


def test_noise_behind_a_limit_and_a_soft_limit_rest_on_no_value() -> None:
    """What the recording alone cannot show is left to the model."""
    noise = np.random.default_rng(3).normal(scale=0.01, size=WAVE.size)
    assert clipped(np.minimum(WAVE, 0.7) + noise) == []
    assert clipped(np.tanh(2.0 * WAVE)) == []


def test_motors_that_are_off_are_not_clipped() -> None:
    assert clipped(np.maximum(WAVE, 0.0)) == []


def test_clean_recordings_have_nothing_to_report() -> None:
    found = inspect(BASE)
    assert found.rate == pytest.approx(500)
    assert found.jitter_p99 < 1e-8
    assert found.gaps == found.missing == found.clipping == ()
    assert found.duplicates == found.out_of_order == found.clock_resets == 0
    assert [joint.name for joint in found.joints] == list(BASE.joints)
    assert all(joint.velocity and joint.effort and not joint.still for joint in found.joints)


def dirty() -> Recording:
    rows = np.concatenate([np.arange(1000), [999, 1001, 1000], np.arange(1050, 2000)])
    position, effort = BASE.position[rows].copy(), BASE.effort[rows].copy()
    position[:, 2] = 0.25
    effort[100:110, 0] = np.nan
    effort[:, 1] = np.minimum(effort[:, 1], 4.0)
    return replace(
        BASE,
        time=BASE.time[rows],
        position=position,
        velocity=np.full_like(position, np.nan),
        effort=effort,
    )


def test_every_fault_is_found_where_it_is() -> None:
    found = inspect(dirty())
    (gap,) = found.gaps
    assert gap.at == pytest.approx(2.002)
    assert gap.length == pytest.approx(0.098)
    assert (found.duplicates, found.out_of_order) == (1, 1)
    (lost,) = found.missing
    assert (lost.joint, lost.quantity, lost.samples) == ("shoulder", "effort", 10)
    assert lost.first == pytest.approx(0.2)
    assert [(c.joint, c.value) for c in found.clipping] == [("elbow", 4.0)]
    assert [joint.still for joint in found.joints] == [False, False, True]
    assert not any(joint.velocity for joint in found.joints)


def test_people_and_machines_get_the_same() -> None:
    found = inspect(dirty())
    record: dict[str, Any] = json.loads(json.dumps(found.record(), allow_nan=False))
    assert record["gaps"][0]["at"] == pytest.approx(2.002)
    assert record["joints"][0]["name"] == "shoulder"
    text = "\n".join(found.lines())
    for words in (
        "500 Hz",
        "98 ms at 2.002 s",
        "stamps repeated by 1 sample",
        "1 sample arrived out of order",
        "shoulder: no effort in 10 of 1953 samples, first at 0.200 s",
        "elbow: effort rests at 4",
        "stands still, no velocity",
    ):
        assert words in text


def test_jitter_is_measured() -> None:
    generator = np.random.default_rng(4)
    found = inspect(replace(BASE, time=BASE.time + generator.uniform(-1e-4, 1e-4, len(BASE))))
    # The difference of two uniform deviations is triangular up to 200 µs.
    assert found.jitter_p50 == pytest.approx(2e-4 * (1 - np.sqrt(0.5)), rel=0.1)
    assert found.jitter_p99 == pytest.approx(2e-4 * 0.9, rel=0.1)


def test_samples_that_are_stamped_together_are_counted() -> None:
    number = np.arange(len(BASE))
    last = BASE.time[np.minimum(5 * (number // 5) + 4, len(BASE) - 1)]
    found = inspect(replace(BASE, time=last + 1e-5 * (number % 5)))
    assert found.batch == 5
    assert found.rate == pytest.approx(inspect(BASE).rate, rel=1e-3)
    assert found.gaps == ()
    assert "stamped together in batches of 5" in "\n".join(found.lines())


def test_a_long_pause_makes_no_batches() -> None:
    found = inspect(replace(BASE, time=BASE.time + 3600.0 * (np.arange(len(BASE)) > 500)))
    assert (found.batch, len(found.gaps)) == (1, 1)


@pytest.mark.parametrize("samples", [0, 1, 2])
def test_nearly_empty_recordings_are_inspected_too(samples: int) -> None:
    found = inspect(swinging(samples))
    assert found.samples == samples
    assert found.lines()
    json.dumps(found.record(), allow_nan=False)


def test_publishers_that_take_turns_are_timed_by_one_of_them() -> None:
    both = BASE.select(("shoulder", "elbow"))
    position, effort = both.position.copy(), both.effort.copy()
    for table in (position, effort):
        table[::2, 0] = table[1::2, 1] = np.nan
    found = inspect(replace(both, position=position, effort=effort))
    assert found.missing == ()
    assert found.rate == pytest.approx(250)
    assert found.gaps == ()
