"""Points between which torque may be linear."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.nodes.streaming.dense import linear_error, needed


@given(seed=st.integers(0, 2**31), error=st.floats(1e-3, 3.0), given_points=st.integers(2, 9))
def test_torque_between_the_points_is_within_the_error(
    seed: int, error: float, given_points: int
) -> None:
    random = np.random.default_rng(seed)
    time = np.cumsum(random.uniform(1e-3, 1e-2, 200))
    tau = np.cumsum(random.standard_normal((200, 2)), axis=0) * [1.0, 10.0]
    own = np.unique(np.append(random.integers(0, 200, given_points), [0, 199]))
    limit = np.array([error, 10.0 * error])
    at = needed(time, tau, own, limit)
    assert np.all(np.diff(at) > 0)
    assert set(own) <= set(at)
    assert np.all(linear_error(time, tau, at) <= limit * (1.0 + 1e-9))


def test_a_line_needs_no_points_and_a_step_needs_two() -> None:
    time = np.linspace(0.0, 1.0, 101)
    own = np.array([0, 100])
    assert len(needed(time, time[:, None], own, np.array([1e-6]))) == 2
    step = np.where(time > 0.505, 1.0, -1.0)[:, None]
    assert list(needed(time, step, own, np.array([0.01]))) == [0, 50, 51, 100]


def test_the_error_without_further_points_is_told() -> None:
    time = np.linspace(0.0, 1.0, 101)
    arc = (time * (1.0 - time))[:, None]
    np.testing.assert_allclose(linear_error(time, arc, np.array([0, 100])), [0.25])
