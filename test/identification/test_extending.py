"""A model with one more effect keeps what the effect has nothing to do with."""

from dataclasses import replace

import numpy as np
import pendulum
import pendulum_models
import pytest

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import Model, extend, without

RIPPLE = 3.0  # N·m


@pytest.fixture(scope="module")
def rippled() -> Model:
    """Return a model of the pendulum whose elbow has a ripple that the model does not know."""
    motion = pendulum.motion(30.0, noise=0.005)
    tau = motion.tau.copy()
    tau[:, 1] += RIPPLE * np.sin(7.0 * motion.q[:, 1])
    return pendulum_models.fitted("chain+fri", replace(motion, tau=tau)).model


@pytest.fixture(scope="module")
def larger(rippled: Model) -> Model:
    return extend(rippled, EFFECTS["ripple"], "elbow").model


def test_only_the_noise_of_the_joint_changes_that_the_effect_was_part_of(
    rippled: Model, larger: Model
) -> None:
    shoulder, elbow = larger.prior.noise / rippled.prior.noise
    assert shoulder == 1.0
    assert elbow < 1.0


def test_an_effect_taken_away_again_leaves_the_noise_of_other_joints(larger: Model) -> None:
    less = without(larger, EFFECTS["ripple"], "elbow")
    shoulder, elbow = less.prior.noise / larger.prior.noise
    assert shoulder == 1.0
    assert elbow >= 1.0
    assert "ripple" not in [term.effect.name for term in less.basis.terms]
