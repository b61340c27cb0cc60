"""The noise of a model with one more effect, and of one with an effect taken away."""

from dataclasses import replace

import numpy as np
import pendulum
import pendulum_models
import pytest

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import Model, extend, without

RIPPLE = 3.0  # N·m


def with_ripple(name: str, noise: float) -> Model:
    """Return a model of the pendulum whose elbow has a ripple that the model does not know.

    Args:
        name: kernel and effects.  noise: as a share of each torque's spread.
    """
    motion = pendulum.motion(30.0, noise=noise)
    tau = motion.tau.copy()
    tau[:, 1] += RIPPLE * np.sin(7.0 * motion.q[:, 1])
    return pendulum_models.fitted(name, replace(motion, tau=tau)).model


@pytest.fixture(scope="module")
def rippled() -> Model:
    return with_ripple("chain+fri", noise=0.005)


@pytest.fixture(scope="module")
def larger(rippled: Model) -> Model:
    return extend(rippled, EFFECTS["ripple"], "elbow").model


def test_the_noise_stays_where_another_makes_no_sure_difference(
    rippled: Model, larger: Model
) -> None:
    """The bodies and friction of `chain` are known from these samples whatever their noise."""
    np.testing.assert_array_equal(larger.prior.noise, rippled.prior.noise)


def test_the_noise_changes_for_all_joints_alike_where_the_error_surely_falls() -> None:
    """Torque with much noise is followed too closely by a kernel without structure."""
    before = with_ripple("vrbfs+fri", noise=0.2)
    after = extend(before, EFFECTS["ripple"], "elbow").model
    shoulder, elbow = after.prior.noise / before.prior.noise
    assert elbow > 1.0
    assert shoulder == pytest.approx(elbow)


def test_an_effect_taken_away_is_noise_again(larger: Model) -> None:
    less = without(larger, EFFECTS["ripple"], "elbow")
    shoulder, elbow = less.prior.noise / larger.prior.noise
    assert elbow >= 1.0
    assert shoulder == pytest.approx(elbow)
    assert "ripple" not in [term.effect.name for term in less.basis.terms]
