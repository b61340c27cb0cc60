"""The arm's reference never jumps, whatever is asked of it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrangian_ff.nodes.common.errors import RefusedReference
from lagrangian_ff.nodes.streaming.follower import Follower, Segment
from lagrangian_ff.nodes.streaming.reference import Reference

SECOND = 1_000_000_000
TOLERANCE = 0.05


def move(begin: float, end: float, start: float, effort: float | None = None) -> Segment:
    """From rest to rest in one second."""
    still = np.zeros((2, 1))
    reference = Reference(
        ("a",), np.array([0.0, 1.0]), np.array([[begin], [end]]), still, still
    )  # fmt: skip
    tau = None if effort is None else np.array([[0.0], [effort]])
    return Segment(reference, round(start * SECOND), tau)


def follower(q: float = 0.0) -> Follower:
    return Follower(("a",), np.array([q]), TOLERANCE)


def position(arm: Follower, time: float) -> float:
    return float(arm.at(round(time * SECOND))[0][0])


def test_it_stands_until_the_start_and_after_the_end() -> None:
    arm = follower(0.2)
    arm.accept(move(0.2, 1.2, 1.0), 0)
    assert position(arm, 0.9) == 0.2
    assert position(arm, 1.5) == pytest.approx(0.7)
    assert position(arm, 9.0) == pytest.approx(1.2)
    assert arm.moving(round(1.9 * SECOND))
    assert not arm.moving(9 * SECOND)


def test_the_present_motion_goes_on_until_the_next_begins() -> None:
    arm = follower()
    arm.accept(move(0.0, 1.0, 0.0), 0)
    assert position(arm, 0.5) == pytest.approx(0.5)
    arm.accept(move(1.0, 0.0, 2.0), SECOND // 2)
    assert position(arm, 0.8) > 0.9
    assert position(arm, 2.5) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("segment", "expected"),
    [
        (move(0.1, 1.0, 0.0), r"a would jump by 0.1000 rad.*; start where the arm is"),
        (move(0.0, 1.0, -5.0), "ended 4.000 s ago"),
        (
            move(0.0, 1.0, -0.5),
            r"jump by 0.5000 rad.*0.500 s after its start: send it earlier",
        ),
    ],
)
def test_jumps_and_what_is_over_are_refused(segment: Segment, expected: str) -> None:
    arm = follower()
    with pytest.raises(RefusedReference, match=expected):
        arm.accept(segment, 0)
    assert position(arm, 3.0) == 0.0


def test_effort_is_linear_between_the_points_and_zero_without() -> None:
    arm = follower()
    arm.accept(move(0.0, 1.0, 0.0, effort=8.0), 0)
    assert [arm.at(round(t * SECOND))[3][0] for t in (0.25, 0.5, 7.0)] == [2.0, 4.0, 8.0]
    assert arm.has_effort
    arm.accept(move(1.0, 1.0, 8.0), 7 * SECOND)
    assert arm.at(9 * SECOND)[3][0] == 0.0


@settings(max_examples=30)
@given(st.lists(st.tuples(*[st.floats(-1.0, 1.0)] * 2, st.floats(0.0, 3.0)), max_size=8))
def test_no_sequence_of_references_makes_it_jump(asked: list[tuple[float, float, float]]) -> None:
    arm = follower()
    time = 0.0
    path = []
    for begin, end, delay in asked:
        try:
            arm.accept(move(begin, end, time + delay), round(time * SECOND))
        except RefusedReference:
            # Also from where it is.
            arm.accept(move(position(arm, time), end, time), round(time * SECOND))
        for _ in range(100):
            path.append(position(arm, time))
            time += 0.01
    # A quintic over one second moves at most 15/8 of its length a second.
    assert np.abs(np.diff(path)).max(initial=0.0) <= 0.01 * 15 / 8 * 2.0 + TOLERANCE + 1e-9
