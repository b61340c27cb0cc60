"""Where the joints are now, and what is drawn of their signals."""

import json
from collections.abc import Sequence

import numpy as np
import pytest

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.attached.bins import WIDTH, Bins
from lagrangian_ff.nodes.attached.poses import Poses
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateView
from lagrangian_ff.record_json import finite

START = 1_700_000_000_000_000_000


class World:
    """A clock and the poses that go by it."""

    def __init__(self) -> None:
        self.now = 0.0
        self.poses = Poses(lambda: self.now)

    def hear(self, names: tuple[str, ...], q: Sequence[float], step: float = 0.01) -> None:
        self.now += step
        none = np.zeros(0)
        view = JointStateView(0, names, np.array(q), none, none)
        self.poses.take(view, START + round(self.now * 1e9))


def test_parts_of_a_robot_that_share_a_topic_are_put_together() -> None:
    world = World()
    for k in range(5):
        world.hear(("a", "b"), [0.1, 0.2])
        world.hear(("c",), [0.001 * k])
    assert world.poses.joints == ("a", "b", "c")
    np.testing.assert_allclose(world.poses.standing(("c", "a")), [0.004, 0.1])


def test_a_joint_that_moves_is_unknown_or_silent_is_refused() -> None:
    world = World()
    world.hear(("a",), [0.0])
    with pytest.raises(UserError, match="too few"):
        world.poses.standing(("a",))
    for k in range(5):
        world.hear(("a",), [0.02 * k])
    with pytest.raises(UserError, match="a moves now"):
        world.poses.standing(("a",))
    with pytest.raises(UserError, match=r"no joint states of b, c: they are of a"):
        world.poses.now(("a", "b", "c"))
    world.now += 1.0
    with pytest.raises(UserError, match=r"stale: none of a for 1\.0 s"):
        world.poses.now(("a",))
    assert world.poses.joints == ()


def test_a_clock_that_is_set_back_does_not_look_like_movement() -> None:
    world = World()
    for k in range(5):
        world.hear(("a",), [0.1 * k])
    world.now -= 0.5
    for _ in range(3):
        world.hear(("a",), [1.0])
    np.testing.assert_allclose(world.poses.standing(("a",)), [1.0])


def test_every_peak_is_drawn_and_nan_is_none() -> None:
    bins = Bins(("a", "b"), ("measured", "residual"), START)
    random = np.random.default_rng(0)
    values = random.normal(size=(101, 2, 2))
    values[37, 0, 1] = 50.0
    values[:, 1, 0] = np.nan
    for k, one in enumerate(values):
        bins.add(START + k * 2_000_000, one)
    found = bins.take()
    assert found is not None
    assert bins.take() is None
    np.testing.assert_allclose(np.diff(found["time"]), WIDTH)
    high = np.array(found["series"]["measured"]["high"])
    low = np.array(found["series"]["measured"]["low"])
    np.testing.assert_allclose(high.max(axis=0), values[:100, 0].max(axis=0), atol=1e-5)
    np.testing.assert_allclose(low.min(axis=0), values[:100, 0].min(axis=0), atol=1e-5)
    assert high[3, 1] == 50.0
    text = json.dumps(finite(found), allow_nan=False)
    assert json.loads(text)["series"]["residual"]["high"][0][0] is None
