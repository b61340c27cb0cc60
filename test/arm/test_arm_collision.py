"""Contacts of the arm with itself and the floor, some in poses beyond its limits."""

from collections.abc import Iterator

import numpy as np
import pytest
from arm_examples import move_to

from lagrangian_ff.arm import HOME, Trajectory, check_clearance
from lagrangian_ff.arm.body import Surroundings
from lagrangian_ff.errors import ArmError


@pytest.fixture(scope="module")
def surroundings() -> Iterator[Surroundings]:
    with Surroundings() as it:
        yield it


def test_zero_and_home_are_clear(surroundings: Surroundings) -> None:
    assert surroundings.first_contact(np.zeros(6)) is None
    assert surroundings.first_contact(np.array(HOME)) is None


def test_reaching_down_touches_the_floor(surroundings: Surroundings) -> None:
    contact = surroundings.first_contact(np.array([0.0, 1.9, 0.3, 0.0, 0.0, 0.0]))
    assert contact is not None
    assert "the floor" in contact


def test_folding_back_touches_the_column(surroundings: Surroundings) -> None:
    contact = surroundings.first_contact(np.array([0.0, 1.2, 1.05, 0.0, 1.0, 0.0]))
    assert contact is not None
    assert "base_link" in contact or "link_1" in contact


def test_a_margin_sees_contacts_before_they_happen() -> None:
    poses = np.linspace([0.0, 0.6, 0.3, 0.0, 0.0, 0.0], [0.0, 1.95, 0.3, 0.0, 0.0, 0.0], 100)

    def first(margin: float) -> int:
        with Surroundings(margin=margin) as it:
            hits = [it.first_contact(q) is not None for q in poses]
        return hits.index(True)

    assert 0 < first(0.02) < first(0.0)


def test_loads_take_room() -> None:
    with Surroundings({"link_6": 2.0}) as heavy, Surroundings() as bare:
        poses = np.linspace([0.0, 0.6, 0.3, 0.0, 0.0, 0.0], [0.0, 1.95, 0.3, 0.0, 0.0, 0.0], 100)
        first = [
            next(k for k, q in enumerate(poses) if it.first_contact(q)) for it in (heavy, bare)
        ]
    assert first[0] < first[1]


def test_a_trajectory_is_refused_with_what_touches_and_when() -> None:
    check_clearance(move_to(HOME, np.zeros(6)))
    low = Trajectory(
        np.array([0.0, 2.0]),
        np.array([HOME, (0.0, 1.9, 0.3, 0.0, 0.0, 0.0)]),
        np.zeros((2, 6)),
        np.zeros((2, 6)),
    )
    with pytest.raises(ArmError, match=r"link_6 and the floor touch at 1\.\d\d s"):
        check_clearance(low)
