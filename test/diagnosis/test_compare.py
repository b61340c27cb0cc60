"""A model held against a motion."""

import numpy as np
import pytest

from lagrangian_ff.diagnosis import compare
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


def test_another_arm_is_refused_with_both_lists(model: Model) -> None:
    with pytest.raises(ModelError, match=r"joints a, b; sine holds a, wrist and lacks b"):
        compare(model, sine(15.0, 0.9, ("a", "wrist")))
