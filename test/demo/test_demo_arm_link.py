"""A run of the arm: how far it is, and that a refused one ends the demo in words."""

from typing import cast

import numpy as np
import pytest

from lagrangian_ff.arm import Trajectory
from lagrangian_ff.demo.arm_link import ArmLink, Drive
from lagrangian_ff.demo.errors import LostRunError

SECOND = 1_000_000_000


class FakeLink:
    """What a `Drive` asks of an arm."""

    name = "/arm"

    def __init__(self) -> None:
        self.start, self.now, self.refusals = 0, 0, 1

    def refused(self) -> int:
        return self.refusals

    def refusal(self) -> str:
        return "joint_6 would jump by 0.5 rad"

    def reported(self) -> int:
        return self.now


@pytest.fixture
def link() -> FakeLink:
    return FakeLink()


@pytest.fixture
def drive(link: FakeLink) -> Drive:
    still = np.zeros((3, 6))
    return Drive(cast(ArmLink, link), Trajectory(np.arange(3.0), still, still, still))


def test_it_is_over_a_little_after_the_end(link: FakeLink, drive: Drive) -> None:
    assert not drive.over()
    link.start, link.now = 5 * SECOND, 6 * SECOND
    assert drive.fraction == pytest.approx(0.5)
    link.now = 7 * SECOND
    assert drive.fraction == 1.0
    assert not drive.over()
    link.now += SECOND
    assert drive.over()


def test_a_refused_motion_ends_the_wait_with_the_reason(link: FakeLink, drive: Drive) -> None:
    link.refusals += 1
    with pytest.raises(
        LostRunError, match=r"/arm refused the motion: joint_6 would jump by 0\.5 rad"
    ):
        drive.over()
