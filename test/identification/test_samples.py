"""Recordings of any length: which samples are used, and that more of them do no harm."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pendulum
import pytest

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import Identification, Model, Settings, extend, identify
from lagrangian_ff.identification.samples import EXACT_TORQUES, INDUCING_POINTS, LONG, sizes
from lagrangian_ff.recording.motion import Motion

FEW_SAMPLES = Settings(samples=100)
FEW = Settings("vrbfs+fri", samples=80, evaluations=20, train=0.5, landmarks=40)


def test_a_short_motion_is_learned_exactly_from_evenly_spread_samples() -> None:
    size = sizes(np.arange(0, 2 * LONG, 2), Settings(samples=100), 6)
    np.testing.assert_array_equal(size.centres, size.seen)
    np.testing.assert_array_equal(size.subset, size.seen)
    assert len(size.subset) == 100
    assert (size.subset[0], size.subset[-1]) == (0, 2 * LONG - 2)


@pytest.mark.parametrize(
    ("available", "settings"),
    [
        (LONG + 1, Settings()),
        (LONG, Settings(samples=EXACT_TORQUES // 6 + 1)),
        (LONG, Settings(landmarks=INDUCING_POINTS)),
    ],
)
def test_much_motion_is_learned_from_whole(available: int, settings: Settings) -> None:
    size = sizes(np.arange(available), settings, 6)
    np.testing.assert_array_equal(size.seen, np.arange(available))
    assert len(size.centres) == INDUCING_POINTS
    assert len(size.subset) <= EXACT_TORQUES // 6


@pytest.mark.parametrize(
    ("available", "joints", "whole"), [(9000, 2, True), (3000, 3, True), (9000, 3, False)]
)
def test_few_joints_are_learned_from_whole_where_it_is_cheap(
    available: int, joints: int, whole: bool
) -> None:
    for settings, structured in ((Settings(), True), (Settings(), False), (FEW_SAMPLES, True)):
        size = sizes(np.arange(available), settings, joints, structured)
        learned = whole and structured and settings is not FEW_SAMPLES
        assert (len(size.seen) == available) == learned


def test_exact_stays_exact_where_it_is_asked_for() -> None:
    size = sizes(np.arange(2 * LONG), Settings(landmarks=0), 6)
    assert len(size.seen) == len(size.centres) == 500


def test_more_inducing_points_than_samples_give_the_exact_model() -> None:
    size = sizes(np.arange(90), Settings(landmarks=100, samples=20), 6)
    np.testing.assert_array_equal(size.seen, np.arange(90))
    np.testing.assert_array_equal(size.centres, np.arange(90))


@pytest.fixture(scope="module")
def motion() -> Motion:
    """Return a motion of the pendulum with torques as no model has them, and noise."""
    motion = pendulum.motion(60.0, 50.0, noise=0.05)
    ripple = 0.8 * np.sin(9.0 * motion.q + 1.0)
    return replace(motion, tau=motion.tau + ripple)


@pytest.fixture(scope="module")
def found(motion: Motion) -> Identification:
    """Return a model of it on inducing points."""
    return identify(motion, FEW)


def test_more_data_make_the_error_no_larger(motion: Motion, found: Identification) -> None:
    exact = identify(motion, replace(FEW, landmarks=0))
    assert exact.record["samples"] == 80
    assert found.record["samples"] == 1500
    assert found.record["landmarks"] == 40
    assert float(str(found.record["rmse"])) <= float(str(exact.record["rmse"]))
    fewer = identify(motion.take(slice(None, None, 4)), FEW)
    assert float(str(found.record["rmse"])) <= 1.02 * float(str(fewer.record["rmse"]))


def test_the_record_says_what_was_learned_from(found: Identification) -> None:
    notes = found.record["notes"]
    assert isinstance(notes, list)
    assert "learned from all 1500 training samples at 50 Hz, with a kernel on 40" in notes[-1]


def test_a_model_on_inducing_points_is_kept_and_refitted_the_same_way(
    found: Identification, tmp_path: Path
) -> None:
    path = tmp_path / "model.npz"
    found.model.save(path)
    again = Model.load(path)
    np.testing.assert_array_equal(again.seen, found.model.seen)
    x = found.held_out.q, found.held_out.qd, found.held_out.qdd
    np.testing.assert_array_equal(again.predict(*x), found.model.predict(*x))
    more = extend(again, EFFECTS["ripple"], "elbow", {"order": 9.0})
    assert (more.record["samples"], more.record["landmarks"]) == (1500, 40)
    joints = more.record["joints"], found.record["joints"]
    after, before = (float(each["elbow"]["rmse"]) for each in joints)  # type: ignore[index]
    assert after < 0.8 * before


def test_all_of_the_motion_is_judged_in_blocks_left_out(motion: Motion) -> None:
    found = identify(motion.take(slice(0, 1500)), replace(FEW, train=1.0))
    assert found.predicted.shape == (1500, 2)
    assert np.isfinite(found.predicted).all()


def test_auto_chooses_a_kernel_for_inducing_points_too(motion: Motion) -> None:
    found = identify(motion, replace(FEW, model="auto+fri", evaluations=10))
    assert found.model.name in ("chain+fri", "chain_rbf+fri")
    assert len(found.model.centres) == 40
    x = found.held_out.take(slice(None, None, 30))
    low, high = found.model.uncertainty.interval(x.q, x.qd, x.qdd)
    assert (low < found.model.predict(x.q, x.qd, x.qdd)).all()
    assert 0.75 < ((low <= x.tau) & (x.tau <= high)).mean() <= 1.0
