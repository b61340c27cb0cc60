"""The noise of a model with one more effect, and of one with an effect taken away."""

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


def test_what_an_effect_explains_is_noise_no_more(rippled: Model, larger: Model) -> None:
    """More weight to one joint alone would pull the common kernel away from the others."""
    shoulder, elbow = larger.prior.noise / rippled.prior.noise
    assert elbow < 1.0
    assert shoulder == pytest.approx(elbow)


def test_an_effect_taken_away_is_noise_again(larger: Model) -> None:
    less = without(larger, EFFECTS["ripple"], "elbow")
    shoulder, elbow = less.prior.noise / larger.prior.noise
    assert elbow >= 1.0
    assert shoulder == pytest.approx(elbow)
    assert "ripple" not in [term.effect.name for term in less.basis.terms]
