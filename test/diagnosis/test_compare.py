"""A model compared with a motion."""

from dataclasses import replace

import numpy as np
import pytest

from lagrangian_ff.diagnosis import compare, with_intervals
from lagrangian_ff.diagnosis.compare import Interval
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.recording.motion import Motion


def sine(seconds: float, size: float, joints: tuple[str, ...] = ("a", "b")) -> Motion:
    """A linear arm: torque is twice the acceleration and gravity's sine."""
    t = np.arange(0.0, seconds, 0.01)
    phase = np.stack([1.1 * t, 1.7 * t], axis=1)
    rate = np.array([1.1, 1.7])
    q, qd, qdd = size * np.sin(phase), size * rate * np.cos(phase), -size * rate**2 * np.sin(phase)
    return Motion(
        joints, t, q, qd, qdd, 2.0 * qdd + np.sin(q), np.zeros(len(t), dtype=np.int64), "sine"
    )


@pytest.fixture(scope="module")
def model() -> Model:
    """Return a model of it."""
    return identify(sine(20.0, 1.0), Settings(samples=80, evaluations=15, train=1.0)).model


def test_errors_are_those_of_the_residual(model: Model) -> None:
    found = compare(model, sine(15.0, 0.9))
    np.testing.assert_allclose(found.score.rmse, np.sqrt(np.mean(found.residual**2, axis=0)))
    variance = found.motion.tau.var(axis=0)
    np.testing.assert_allclose(found.score.nmse, found.score.rmse**2 / variance)
    assert set(found.record()) >= {"joints", "rmse", "nmse", "outside_range"}


def test_joints_are_matched_by_name(model: Model) -> None:
    motion = sine(15.0, 0.9)
    turned = motion.select(("b", "a"))
    np.testing.assert_allclose(compare(model, turned).predicted, compare(model, motion).predicted)


def test_leaving_the_known_range_is_noticed(model: Model) -> None:
    assert compare(model, sine(15.0, 0.9)).outside == 0.0
    assert compare(model, sine(15.0, 2.0)).outside > 0.3


def noisy(model_of: float, friction: float = 0.0, seconds: float = 60.0) -> Motion:
    """The arm with noise, so that its model is not sure of everything, and friction at joint b."""
    motion = sine(seconds, model_of)
    tau = motion.tau + 0.05 * np.random.default_rng(int(seconds)).normal(size=motion.tau.shape)
    tau[:, 1] += friction * np.sign(motion.qd[:, 1])
    return replace(motion, tau=tau)


@pytest.fixture(scope="module")
def humble() -> Model:
    """Return a model of the noisy arm."""
    return identify(noisy(1.0), Settings(samples=80, evaluations=15, train=1.0)).model


def test_nine_of_ten_measured_torques_lie_in_their_intervals(humble: Model) -> None:
    found = compare(humble, noisy(0.9, seconds=50.0), intervals=True)
    assert found.interval is not None
    assert len(found.interval.at) <= 1500
    np.testing.assert_allclose(found.interval.covered, 0.9, atol=0.08)
    assert found.record()["too_sure"] == ""
    every = with_intervals(humble, found).interval
    assert every is not None
    assert len(every.at) == len(found.motion)
    np.testing.assert_allclose(every.reach[found.interval.at], found.interval.reach)


def test_a_model_of_an_arm_that_changed_is_too_sure(humble: Model) -> None:
    record = compare(humble, noisy(0.9, friction=0.2, seconds=50.0), intervals=True).record()
    covered = record["covered"]
    assert isinstance(covered, dict)
    assert covered["b"] < 0.5
    assert covered["a"] > 0.8
    assert f"only {covered['b']:.0%} of b lie inside its 90% intervals" in str(record["too_sure"])


def test_a_short_motion_may_miss_more_by_chance(humble: Model) -> None:
    chance = Interval(("a",), np.arange(3), np.ones((3, 1)), np.array([0.6]), 5)
    assert not chance.words()
    assert replace(chance, seconds=60).too_sure == ("a",)


def test_where_nobody_asks_or_the_file_is_of_before_there_are_no_intervals(humble: Model) -> None:
    motion = noisy(0.9, seconds=10.0)
    assert "covered" not in compare(humble, motion).record()
    of_before = replace(humble, record={})
    assert compare(of_before, motion, intervals=True).interval is None


def test_another_arm_is_refused_with_both_lists(model: Model) -> None:
    with pytest.raises(ModelError, match=r"joints a, b; sine holds a, wrist and lacks b"):
        compare(model, sine(15.0, 0.9, ("a", "wrist")))
