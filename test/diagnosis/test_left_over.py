"""What depends on several joints at once is named by them, and noise is called noise."""

from dataclasses import replace

import numpy as np
import pytest
import two_rods
from diagnosed_rods import model_of
from numpy.typing import NDArray
from sines import sines
from whitened_examples import SHORT, few_torques

from lagrangian_ff.diagnosis import diagnose, verdict
from lagrangian_ff.diagnosis.results import Diagnosis
from lagrangian_ff.diagnosis.search.products import FACTORS, pool, products_of
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.kernels import States
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

JOINTS = (*two_rods.JOINTS, "wrist")


_small = few_torques(1500, SHORT)


def motion(seed: int, tied: float = 0.0, once: float = 0.0) -> Motion:
    """Two rods and a hand that turns at their end: 40 s at 100 Hz.

    Args:
        tied: N·m on the elbow, times the sines of all three positions.
        once: the same on the shoulder, of positions and a phase that no recording shares.
    """
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 40.0, 0.01)
    q, qd, qdd = sines(rng, t, 3, (0.4, 4.0))
    tau = np.column_stack([two_rods.rods(q[:, :2], qd[:, :2], qdd[:, :2]), 0.05 * qdd[:, 2]])
    tau += np.array([2.0, 0.4, 0.1]) * qd + np.array([3.0, 0.8, 0.2]) * np.tanh(qd / 0.02)
    tau[:, 1] += tied * np.prod(np.sin(q), axis=1)
    phase = rng.uniform(0.0, 2.0 * np.pi)
    tau[:, 0] += once * np.sin(q[:, 0]) * np.sin(q[:, 1] + phase) * np.sin(q[:, 2] + phase)
    tau += np.array([0.15, 0.05, 0.02]) * rng.normal(size=tau.shape)
    segment = np.zeros(len(t), dtype=np.int64)
    return Motion(JOINTS, t, q, qd, qdd, tau, segment, source=f"recording {seed}")


def diagnosed(first: Motion, second: Motion) -> Diagnosis:
    """Return the diagnosis of a model identified from the first motion."""
    few = Settings(samples=150, evaluations=15, train=1.0)
    return diagnose(identify(first, few).model, first, second)


def test_a_torque_of_three_joints_is_named_by_them() -> None:
    found = diagnosed(motion(1, tied=1.0), motion(2, tied=1.0))
    assert not found.confirmed
    (rest,) = found.unexplained
    assert rest.joint == "elbow"
    assert rest.coordinate == "the positions of shoulder, elbow and wrist"
    with_it, without = motion(1, tied=1.0).tau[:, 1], motion(1).tau[:, 1]
    share = np.std(with_it - without) / np.std(with_it)
    assert 0.5 * share < rest.share < 1.2 * share
    assert "depends on the positions of shoulder, elbow and wrist" in verdict(found)


def test_what_the_other_recording_does_not_show_is_not_claimed() -> None:
    found = diagnosed(motion(1, once=2.0), motion(2, once=2.0))
    assert not found.confirmed
    assert not found.unexplained
    assert [one.joint for one in found.remainders] == ["shoulder"]
    assert "what is left is noise" not in verdict(found)


def slow(t: Floats, q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """A torque of the shoulder that changes over time."""
    return np.stack([0.5 * np.sin(t / 4.0), np.zeros(len(t))], axis=1)


@pytest.mark.parametrize("hidden", [two_rods.sore_spot, slow])
def test_a_curve_that_does_not_come_again_is_left_as_large_as_it_is(
    hidden: two_rods.Hidden,
) -> None:
    first, without = two_rods.motion(1, hidden=hidden), two_rods.motion(1)
    found = diagnose(model_of(hidden), first, two_rods.motion(2))
    assert not found.unexplained
    (left,) = found.remainders
    torque = np.sqrt(np.mean((first.tau - without.tau)[:, 0] ** 2))
    assert left.joint == "shoulder"
    assert 0.8 * torque < left.size < 1.1 * torque


def test_the_columns_of_a_product_are_those_that_all_share() -> None:
    made = motion(1).take(slice(0, 300, 10))
    x = Inputs.of(States.of(made.q, made.qd, made.qdd), made.time, made.segment)
    x = replace(x, load=np.ones_like(x.q))
    raw, places = pool(x, 1)
    every = list(products_of(x, 1))
    assert {one.factor for one in every} == set(FACTORS)
    for one in every:
        shared = np.concatenate([raw[:, places[part]] for part in one.parts], axis=1)
        np.testing.assert_allclose(shared, one.columns(x, 1))


def test_a_joint_that_stands_still_takes_no_part() -> None:
    made = motion(1).take(slice(0, 300, 10))
    still = np.column_stack([made.q[:, :2], np.full(len(made), 0.3)])
    x = Inputs.of(States.of(still, made.qd, made.qdd), made.time, made.segment)
    assert all(2 not in one.positions for one in products_of(x, 0))
