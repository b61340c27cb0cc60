"""A motion as it is sent: slowly to its start, and to rest on its own path."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.arm.trajectory import Trajectory
from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.attached.motions import FASTEST, RESTING, SHORTEST, held, plan, slowed

JOINTS = ("a", "b")
STILL = np.zeros((3, 2))
MOTION = Trajectory(
    np.array([1.0, 2.0, 4.0]), np.array([[0.0, 0.1], [0.8, 0.1], [0.0, 0.4]]), STILL, STILL, JOINTS
)
angles = st.floats(-2.0, 2.0)


@given(angles, angles)
def test_the_way_is_slow_and_the_motion_itself_is_not_changed(a: float, b: float) -> None:
    q = np.array([a, b])
    made = plan(MOTION, q)
    time = np.linspace(0.0, made.way, 400)
    way, speed, _ = made.trajectory.sample(time)
    np.testing.assert_allclose(way[0], q)
    np.testing.assert_allclose(way[-1], MOTION.q[0], atol=1e-12)
    assert np.abs(speed).max() <= FASTEST * (1.0 + 1e-9)
    assert made.way >= SHORTEST
    assert np.all(np.abs(speed).max(axis=0) <= 0.5 * made.fastest * (1.0 + 1e-6) + 0.05)
    np.testing.assert_allclose(made.moved, MOTION.q[0] - q)
    np.testing.assert_allclose(
        made.trajectory.sample(made.way + time[time < 3.0])[0],
        MOTION.sample(1.0 + time[time < 3.0])[0],
        atol=1e-9,
    )


def test_a_motion_that_does_not_rest_at_its_ends_is_refused() -> None:
    for end, words in ((0, "begin"), (2, "end")):
        qd = STILL.copy()
        qd[end, 1] = 2.0 * RESTING
        moving = Trajectory(MOTION.time, MOTION.q, qd, STILL, JOINTS)
        with pytest.raises(UserError, match=f"does not {words} at rest: b moves"):
            plan(moving, MOTION.q[0])
    one = Trajectory(MOTION.time[:1], MOTION.q[:1], STILL[:1], STILL[:1], JOINTS)
    with pytest.raises(UserError, match="one point only"):
        plan(one, MOTION.q[0])


@given(st.floats(0.0, 4.0))
def test_a_stop_begins_as_the_motion_is_and_stays_on_its_path(at: float) -> None:
    rest = slowed(MOTION, at)
    q, qd, qdd = (x[0] for x in MOTION.sample(np.array([1.0 + at])))
    np.testing.assert_allclose(rest.q[0], q, atol=1e-12)
    np.testing.assert_allclose(rest.qd[0], qd, atol=1e-12)
    np.testing.assert_allclose(rest.qdd[0], qdd, atol=1e-12)
    np.testing.assert_allclose(rest.qd[-1], 0.0, atol=1e-12)
    fine = np.linspace(0.0, rest.duration, 100)
    path = MOTION.sample(1.0 + np.linspace(at, at + rest.duration, 400))[0]
    away = np.abs(rest.sample(fine)[0][:, None] - path[None]).max(axis=2).min(axis=1)
    assert away.max() < 2e-3
    # Positions, velocities and accelerations belong together.
    slope = np.gradient(rest.sample(fine)[0], fine, axis=0)
    np.testing.assert_allclose(slope[1:-1], rest.sample(fine)[1][1:-1], atol=0.02)


def test_what_is_held_does_not_move() -> None:
    rest = held(JOINTS, np.array([0.3, -0.2]))
    q, qd, qdd = rest.sample(np.linspace(-1.0, 2.0, 20))
    np.testing.assert_allclose(q, np.tile([0.3, -0.2], (20, 1)))
    assert not qd.any()
    assert not qdd.any()
