"""A lag of all torques: found as one number, set right, and confirmed on unseen motion."""

from dataclasses import replace

import numpy as np
import pytest
import two_rods
from diagnosed_rods import FEW
from numpy.typing import NDArray
from whitened_examples import clean_rods, few_torques, quickly, whitened_of

from lagrangian_ff.diagnosis import diagnose, diagnosis_record, verdict
from lagrangian_ff.diagnosis.search.lag import allowing, earlier, hysteresis_of, lag_of, set_right
from lagrangian_ff.diagnosis.thresholds import USED
from lagrangian_ff.diagnosis.whitening import Whitened
from lagrangian_ff.effects.memory import stop
from lagrangian_ff.identification import identify
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

LATE = 0.009  # s


_small = few_torques(1200)


def late(seed: int, delay: float = LATE, hidden: two_rods.Hidden | None = None) -> Motion:
    return earlier(two_rods.motion(seed, 30.0, hidden), -delay)


@pytest.fixture(scope="module", params=[LATE, -0.5 * LATE])
def lagging(request: pytest.FixtureRequest) -> tuple[Whitened, float]:
    """Return a motion whose torques are late, and by how much."""
    with quickly(1000):
        return whitened_of(late(1, request.param)), request.param


def test_its_size_is_found(lagging: tuple[Whitened, float]) -> None:
    whitened, delay = lagging
    _, lag = set_right(whitened, hysteresis_of(whitened))
    assert lag.log_bayes_factor > USED.floor
    assert abs(lag.delay - delay) < 3.0 * lag.deviation < 0.4 * abs(delay)


def test_none_is_left_of_it(lagging: tuple[Whitened, float]) -> None:
    beside = hysteresis_of(lagging[0])
    moved, lag = set_right(lagging[0], beside)
    left = lag_of(moved, beside)
    assert abs(left.delay) < 0.2 * lag.deviation
    power = [np.mean(one.residual**2) * one.system.amplitude for one in (lagging[0], moved)]
    assert power[1] < power[0]


def test_a_motion_in_step_has_none() -> None:
    assert lag_of(clean_rods()).log_bayes_factor < 0.0


def soft(t: Floats, q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """Most of both joints' dry friction builds up over some mrad."""
    segment, strengths = np.zeros(len(t), dtype=np.int64), (2.6, 0.7)
    columns = []
    for n, strength in enumerate(strengths):
        sign = np.tanh(qd[:, n] / two_rods.WIDTH)
        columns.append(strength * (stop(q[:, n], segment, sign, 0.006) - sign))
    return np.stack(columns, axis=1)


def test_friction_that_builds_up_in_all_gears_is_no_lag() -> None:
    with quickly(1000):
        whitened = whitened_of(two_rods.motion(1, 30.0, soft))
    assert lag_of(whitened).log_bayes_factor > USED.floor  # it does look like one
    assert lag_of(whitened, hysteresis_of(whitened)).log_bayes_factor < USED.floor
    first, second = (two_rods.motion(seed, 30.0, soft) for seed in (1, 2))
    assert diagnose(identify(first, FEW).model, first, second).lag is None


def test_where_it_is_explained_nothing_is_left_to_find() -> None:
    whole = allowing(clean_rods())
    column = whole.late()
    assert np.linalg.norm(whole.project(column[:, None])) < 1e-6 * np.linalg.norm(column)
    again = whole.explaining(whole.basis, ())
    np.testing.assert_allclose(again.residual, whole.residual)


def test_a_diagnosis_names_it_and_what_is_hidden_beside_it() -> None:
    first, second = (late(seed, LATE, two_rods.stick) for seed in (1, 2))
    found = diagnose(identify(first, FEW).model, first, second)
    assert found.lag is not None
    assert abs(found.lag.delay - LATE) < 3.0 * found.lag.deviation
    assert found.lag.gained > USED.floor
    assert [(one.effect.name, one.joint) for one in found.confirmed] == [("stribeck", "elbow")]
    np.testing.assert_array_equal(found.motion.tau, first.tau)  # as it was recorded
    assert verdict(found).startswith("The torque of every joint comes ")
    assert found.lag.option in verdict(found)
    assert diagnosis_record(found)["lag"]["delay"] == found.lag.delay
    assert found.lag.option == f"--effort-delay {found.lag.delay:.4f}"


def test_one_that_unseen_motion_lacks_is_not_believed() -> None:
    first, second = late(1), two_rods.motion(2, 30.0)
    found = diagnose(identify(first, FEW).model, first, second)
    assert found.lag is None


def test_a_model_that_was_read_in_step_needs_no_more() -> None:
    first, second = (two_rods.motion(seed, 30.0) for seed in (1, 2))
    first = replace(first, conditioning={"effort_delay": LATE})
    found = diagnose(identify(first, FEW).model, first, second)
    assert found.lag is None
    assert not found.confirmed


def test_torques_move_within_segments_only() -> None:
    motion = two_rods.motion(1, 30.0)
    half = np.repeat([0, 1], len(motion) // 2)
    moved = earlier(replace(motion, segment=half), LATE)
    for part in (half == 0, half == 1):
        time, tau = motion.time[part], motion.tau[part]
        for joint in range(2):
            expected = np.interp(time + LATE, time, tau[:, joint])
            np.testing.assert_array_equal(moved.tau[part, joint], expected)
