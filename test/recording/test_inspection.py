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
