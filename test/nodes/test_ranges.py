"""The doubt of a torque: its unit, the states it is evaluated at, and its consequences."""

from dataclasses import replace

import numpy as np
import pytest
from fake_model import FakeModel, Floats
from small_model import JOINTS, motion_at, save_small_model

from lagrangian_ff.identification import Model
from lagrangian_ff.nodes.common.status import Level
from lagrangian_ff.nodes.streaming.plan import Plan, Policy, make_plan
from lagrangian_ff.nodes.streaming.ranges import (
    CHUNK,
    STEP,
    Doubt,
    along,
    doubt_status,
    doubt_words,
    fade_around,
)
from lagrangian_ff.nodes.streaming.reference import Reference, RefusedReference

LIMIT = 0.5


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    """Return a small model."""
    return save_small_model(tmp_path_factory.mktemp("doubt") / "model.npz")


def turn() -> Reference:
    """Return a motion of both joints at 1 rad/s from 0 to 1 rad."""
    time = np.linspace(0.0, 1.0, 11)
    q, zero = np.column_stack([time, time]), np.zeros((11, 2))
    return Reference(JOINTS, time, q, zero + 1.0, zero)


def beyond(q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """Return a doubt of joint b that is as large as its angle in rad."""
    return np.column_stack([0.0 * q[:, 0], np.abs(q[:, 1])])


def plan_of(policy: Policy) -> Plan:
    return make_plan(FakeModel(), turn(), policy, doubts=beyond)


def test_it_is_the_interval_over_the_largest_torque(model: Model) -> None:
    q, qd, qdd = motion_at(np.linspace(0.0, 20.0, 9))
    low, high = model.quick_uncertainty.interval(q, qd, qdd)
    found = Doubt(model)(q, qd, qdd)
    np.testing.assert_allclose(found, 0.5 * (high - low) / model.range.tau_max, rtol=1e-6)
    far = Doubt(model)(q, 8.0 * qd, 64.0 * qdd)
    assert (far.max(axis=0) > 3.0 * found.max(axis=0)).all()


def test_a_stream_of_set_points_has_the_answer_to_the_last_look(model: Model) -> None:
    found = Doubt(model)
    q, qd, qdd = motion_at(np.array([0.0, 1.0]))
    assert not found.latest(q[:1], qd[:1], qdd[:1]).any()
    found.look(q[:1], qd[:1], qdd[:1])
    latest = found.latest(q[1:], 5.0 * qd[1:], qdd[1:])
    np.testing.assert_allclose(latest, found(q[:1], qd[:1], qdd[:1]))


def test_models_without_a_calibration_have_no_doubt(model: Model) -> None:
    assert Doubt.of(replace(model, record={})) is None
    assert Doubt.of(model) is not None


def test_it_is_asked_at_few_states_and_holds_for_those_after_them() -> None:
    asked: list[int] = []

    def counted(q: Floats, qd: Floats, qdd: Floats) -> Floats:
        asked.append(len(q))
        return q

    times = np.linspace(0.0, 2.0, 501)
    q = np.column_stack([times, 2.0 * times])
    found = along(counted, times, (q, q, q))
    assert found.shape == q.shape
    assert sum(asked) <= 2.0 / STEP + 1
    assert max(asked) <= CHUNK
    assert (q - found >= 0.0).all()
    assert (q - found <= 2.0 * STEP + 1e-9).all()


def test_nothing_changes_unless_a_limit_is_set() -> None:
    plain = make_plan(FakeModel(), turn(), Policy())
    plan = plan_of(Policy())
    np.testing.assert_array_equal(plan.weight, plain.weight)
    assert plan.excess.worst == ""
    assert plan.doubt is not None
    np.testing.assert_allclose(plan.doubt, [0.0, 1.0], atol=STEP)


def test_above_the_limit_the_torque_fades_and_the_joint_is_named() -> None:
    plan = plan_of(Policy(fade_time=0.2, doubt_limit=LIMIT))
    assert (plan.weight[plan.time > LIMIT + STEP] == 0.0).all()
    assert (plan.weight[plan.time < LIMIT - 0.2] == 1.0).all()
    assert "the torque of b is known to ±" in plan.excess.worst
    assert "the largest identified is 50 N·m" in plan.excess.worst
    with pytest.raises(RefusedReference, match="torque of b"):
        plan_of(Policy("refuse", doubt_limit=LIMIT))
    assert (plan_of(Policy("allow", doubt_limit=LIMIT)).weight == 1.0).all()


def test_the_words_give_the_largest_doubt_in_newton_metres() -> None:
    found = np.array([[0.1, 0.2], [0.3, 1.5], [0.1, 0.4]])
    times, largest = np.array([0.0, 1.0, 2.0]), np.array([10.0, 4.0])
    said = doubt_words(JOINTS, times, found, largest, 1.0)
    assert said.startswith("the torque of b is known to ±6 N·m only at 1.000 s")
    assert doubt_words(JOINTS, times, found, largest, 2.0) == ""


def test_the_status_warns_of_guesses() -> None:
    sure, unsure = np.array([0.1, 0.3]), np.array([1.2, 1.5])
    found = doubt_status(JOINTS, True, sure, 0.0)
    assert found.level is Level.OK
    assert found.message == "known to 30% of the largest torque or better (b)"
    assert found.values == {"doubt a": 0.1, "doubt b": 0.3}
    assert doubt_status(JOINTS, True, sure, 0.2).level is Level.WARN
    guess = doubt_status(JOINTS, True, unsure, 0.0)
    assert guess.level is Level.WARN
    assert (
        guess.message == "the torque is a guess: b (±150% of its largest), a (±120% of its largest)"
    )
    assert doubt_status(JOINTS, True, None, 0.0).message == "no reference"
    assert "identify again" in doubt_status(JOINTS, False, None, 0.0).message


def test_fading_takes_its_time_on_both_sides() -> None:
    time = np.linspace(0.0, 4.0, 401)
    outside = (time > 1.0) & (time < 2.0)
    weight = fade_around(time, outside, 0.5)
    expected = np.clip(np.maximum(1.005 - time, time - 1.995) / 0.5, 0.0, 1.0)
    np.testing.assert_allclose(weight, expected, atol=0.02)
    assert (fade_around(time, np.zeros(401, dtype=bool), 0.5) == 1.0).all()
