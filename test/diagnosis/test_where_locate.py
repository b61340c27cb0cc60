"""Where a model fails, from a model and a motion to a record."""

import json
from dataclasses import replace

import numpy as np
import pytest

from lagrangian_ff.diagnosis import compare
from lagrangian_ff.diagnosis.where import Localisation, locate
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.recording.motion import Motion


def arm(seconds: float, size: float = 1.0, bump: float = 0.0) -> Motion:
    """Two joints with inertia, gravity and friction; joint b with a bump of it at low speed."""
    t = np.arange(0.0, seconds, 0.01)
    rates, phases = np.array([[1.1, 2.9], [1.7, 3.7]]), np.array([[0.0, 1.0], [0.5, 2.0]])
    angle = rates * t[:, None, None] + phases
    amplitude = size * np.array([0.6, 0.3])
    q = (amplitude * np.sin(angle)).sum(axis=2)
    qd = (amplitude * rates * np.cos(angle)).sum(axis=2)
    qdd = -(amplitude * rates**2 * np.sin(angle)).sum(axis=2)
    tau = 2.0 * qdd + np.sin(q) + 0.5 * qd + np.tanh(qd / 0.02)
    tau[:, 1] += bump * np.tanh(qd[:, 1] / 0.02) * np.exp(-((qd[:, 1] / 0.15) ** 2))
    tau += 0.02 * np.random.default_rng(0).normal(size=tau.shape)
    return Motion(("a", "b"), t, q, qd, qdd, tau, np.zeros(len(t), dtype=np.int64), "arm")


@pytest.fixture(scope="module")
def model() -> Model:
    """Return a model of the arm without the bump."""
    return identify(arm(30.0), Settings(samples=120, evaluations=20, train=1.0)).model


@pytest.fixture(scope="module")
def found(model: Model) -> Localisation:
    """Return where it fails on the arm with the bump."""
    return locate(model, compare(model, arm(40.0, 0.9, bump=1.5), intervals=True))


def test_the_bump_is_named_on_its_joint_and_speed(found: Localisation) -> None:
    region = found.regions[0]
    assert region.joint == "b"
    assert region.conditions[0].coordinate == "velocity"
    assert -0.5 < region.conditions[0].low < 0.0 < region.conditions[0].high < 0.5
    assert found.words()[0].startswith("b below 0.")


def test_the_record_is_json_and_holds_what_is_promised(found: Localisation) -> None:
    record = found.record()
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    assert {"joints", "rmse", "nmse", "regions", "blocks", "bins", "spectra", "words"} <= set(
        record
    )
    first = record["regions"]
    assert isinstance(first, list)
    assert {
        "joint", "coordinate", "low", "high", "share_of_error", "share_of_time",
    } <= set(first[0])  # fmt: skip
    assert "series" not in record


def test_the_blocks_hold_all_of_the_error(found: Localisation) -> None:
    blocks = found.record()["blocks"]
    assert isinstance(blocks, list)
    assert len(blocks) == 13
    for n, joint in enumerate(("a", "b")):
        squared = [block["joints"][joint] ** 2 for block in blocks]
        expected = found.comparison.score.rmse[n] ** 2
        assert np.mean(squared) == pytest.approx(expected, rel=0.05)


def test_a_page_draws_the_samples_with_intervals_evenly_spaced(found: Localisation) -> None:
    comparison, interval = found.comparison, found.comparison.interval
    assert interval is not None
    shown = comparison.shown
    np.testing.assert_array_equal(shown, interval.at)
    np.testing.assert_array_equal(shown, replace(comparison, interval=None).shown)
    assert len(shown) <= 1500
    assert len(set(np.diff(shown))) == 1
    inside = np.mean(np.abs(comparison.residual[shown, 1]) <= interval.reach[:, 1])
    covered = found.record()["covered"]
    assert isinstance(covered, dict)
    assert covered["b"] == pytest.approx(inside)


def test_the_load_is_the_models_and_never_the_measured_torque(model: Model) -> None:
    motion = arm(20.0)
    spoiled = replace(motion, tau=motion.tau + 100.0)
    clean, dirty = (locate(model, compare(model, one)).series.load for one in (motion, spoiled))
    np.testing.assert_array_equal(clean, dirty)


def test_leaving_the_known_range_is_told(model: Model) -> None:
    wide = locate(model, compare(model, arm(20.0, 1.6))).record()["outside"]
    inside = locate(model, compare(model, arm(20.0, 0.8))).record()["outside"]
    assert isinstance(wide, dict)
    assert isinstance(inside, dict)
    assert wide["share_of_time"] > 0.2
    assert wide["joints"]["a"]["rmse_outside"] > wide["joints"]["a"]["rmse_inside"]
    assert inside["share_of_time"] == 0.0
    assert inside["joints"]["a"]["rmse_outside"] is None


@pytest.mark.parametrize("seconds", [0.05, 0.5, 2.0])
def test_short_motions_are_looked_at_without_complaint(model: Model, seconds: float) -> None:
    record = locate(model, compare(model, arm(seconds))).record()
    assert record["regions"] == []
    assert record["too_short"]
    assert record["words"] == [
        "the motion is too short to tell where the error lies: record 5 s or more"
    ]
    json.dumps(record, allow_nan=False)


def test_joints_that_stand_still_are_looked_at_too(model: Model) -> None:
    motion = arm(10.0)
    zero = np.zeros_like(motion.q)
    still = replace(motion, q=zero + 0.3, qd=zero, qdd=zero)
    record = locate(model, compare(model, still)).record()
    json.dumps(record)
    assert record["spectra"] == []
