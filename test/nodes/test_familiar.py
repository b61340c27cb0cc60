"""States that come again: what comes then is compared with what came before."""

import numpy as np
import pytest
from small_model import JOINTS, Floats, motion_at, torque_of

from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.nodes.watching.familiar import MEMORY, SETTLED, VISITS, Familiar
from lagrangian_ff.recording import Recording, condition

CYCLE, PAUSE, STEP = 12.0, 3.0, 0.01  # s
NOISE = 0.01  # N·m


@pytest.fixture(scope="module")
def model() -> Model:
    time = np.arange(0.0, 20.0, STEP)
    q, qd, qdd = motion_at(time)
    recording = Recording(JOINTS, time, q, qd, torque_of(q, qd, qdd))
    return identify(condition(recording), Settings(train=1.0, samples=200, evaluations=5)).model


TOUCH = slice(600, 630)
"""States of a cycle with a touch."""


def cycle(familiar: Familiar, number: int, touch: float = 0.0, shift: float = 0.0) -> list[Floats]:
    """Return what is said of a cycle whose output is large and depends on the state alone.

    Args:
        touch: N·m on the second joint.  shift: rad.
    """
    random, time = np.random.default_rng(number), np.arange(0.0, CYCLE, STEP)
    q, qd, _ = motion_at(time)
    output = 5.0 * np.sin(3.0 * q) + NOISE * random.normal(size=q.shape)
    output[TOUCH, 1] += touch
    begin = 100.0 + number * (CYCLE + PAUSE)
    found = [
        familiar.take(round((begin + now) * 1e9), q[k] + shift, qd[k], output[k][None])
        for k, now in enumerate(time)
    ]
    return [one for one in found if one is not None]


@pytest.fixture
def familiar(model: Model) -> Familiar:
    """Return a memory that has seen enough cycles to judge the next."""
    familiar = Familiar(model, 1)
    for number in range(VISITS):
        assert cycle(familiar, number) == []
    assert len(cycle(familiar, VISITS)) <= round(CYCLE / STEP) - SETTLED
    return familiar


def test_what_comes_again_is_no_more_than_its_noise(familiar: Familiar) -> None:
    found = np.array(cycle(familiar, VISITS + 1))
    assert len(found) == round(CYCLE / STEP)
    assert 0.5 < np.sqrt(np.mean(found**2)) < 1.5
    assert np.max(found) < 6.0


def test_a_touch_far_below_the_usual_output_stands_out(familiar: Familiar) -> None:
    found = np.array(cycle(familiar, VISITS + 1, touch=12.0 * NOISE))[TOUCH, 0]
    assert np.min(found[:, 1]) > 5.0 > np.max(found[:, 0])


def test_one_touch_before_does_not_hide_the_next(familiar: Familiar) -> None:
    cycle(familiar, VISITS + 1, touch=100.0 * NOISE)
    found = np.array(cycle(familiar, VISITS + 2, touch=15.0 * NOISE))
    assert np.min(found[TOUCH, 0, 1]) > 5.0


def test_states_where_the_arm_never_was_are_not_judged(familiar: Familiar) -> None:
    assert cycle(familiar, VISITS + 1, shift=0.5) == []


def test_the_oldest_is_forgotten(familiar: Familiar) -> None:
    for number in range(VISITS + 1, VISITS + 2 + round(MEMORY / CYCLE)):
        cycle(familiar, number, shift=0.5)
    assert cycle(familiar, number + 1) == []
