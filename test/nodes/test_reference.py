"""References: matched by name, completed, refused with a reason, followed without jumps."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from lagrangian_ff.nodes.streaming.reference import (
    Follower,
    Points,
    Reference,
    RefusedReference,
    Segment,
    read_path,
    read_reference,
)

T = np.linspace(0.0, 2.0, 41)


def smooth(time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    w = np.array([1.3, 2.1])
    phase = time[:, None] * w
    return np.sin(phase), w * np.cos(phase), -(w**2) * np.sin(phase)


def points(**changes: Any) -> Points:
    q, qd, qdd = smooth(T)
    fields = {
        "names": ["a", "b"], "time": list(T), "position": q.tolist(),
        "velocity": qd.tolist(), "acceleration": qdd.tolist(),
    }  # fmt: skip
    return Points(**{**fields, **changes})


EMPTY: list[list[float]] = [[] for _ in T]


def test_columns_follow_the_wanted_joints_and_others_are_ignored() -> None:
    reference = read_reference(points(names=["b", "x"]), ["b"])
    np.testing.assert_array_equal(reference.q[:, 0], smooth(T)[0][:, 0])
    assert reference.joints == ("b",)
    assert reference.filled == ()


def test_between_points_the_motion_is_smooth_and_exact_to_sixth_order() -> None:
    reference = read_reference(points(), ["a", "b"])
    fine = np.linspace(0.0, 2.0, 997)
    for found, expected in zip(reference.sample(fine), smooth(fine), strict=True):
        np.testing.assert_allclose(found, expected, atol=2e-6)


@given(arrays(float, (3, 6), elements=st.floats(-5.0, 5.0)), st.floats(0.01, 3.0))
def test_samples_meet_the_points_and_derivatives_are_derivatives(
    values: np.ndarray, span: float
) -> None:
    time = np.array([0.0, span, 2.5 * span])
    reference = Reference(("a", "b"), time, values[:, :2], values[:, 2:4], values[:, 4:])
    for found, expected in zip(
        reference.sample(time), (values[:, :2], values[:, 2:4], values[:, 4:]), strict=True
    ):
        np.testing.assert_allclose(found, expected, atol=1e-6 * (1.0 + 1.0 / span**2))
    inside = np.linspace(0.1, 2.3, 7) * span
    h = 1e-4 * span
    ahead, behind, now = (reference.sample(inside + d) for d in (h, -h, 0.0))
    scale = 1.0 + 1.0 / span**2
    np.testing.assert_allclose((ahead[0] - behind[0]) / (2 * h), now[1], atol=1e-3 * scale)


def test_outside_its_time_the_reference_stands_still() -> None:
    q, qd, qdd = read_reference(points(), ["a", "b"]).sample(np.array([-1.0, 5.0]))
    np.testing.assert_allclose(q, smooth(T[[0, -1]])[0])
    assert not qd.any()
    assert not qdd.any()


def test_missing_velocities_and_accelerations_are_filled_and_said() -> None:
    bell = (T / 2.0) ** 3 * (10 - 15 * (T / 2.0) + 6 * (T / 2.0) ** 2)
    table = np.column_stack([bell, -bell]).tolist()
    reference = read_reference(
        points(position=table, velocity=EMPTY, acceleration=EMPTY), ["a", "b"]
    )
    s = T / 2.0
    np.testing.assert_allclose(reference.qd[:, 0], 15 * s**2 * (1 - s) ** 2, atol=1e-6)
    np.testing.assert_allclose(reference.qdd[:, 1], -15 * s * (1 - s) * (1 - 2 * s), atol=1e-5)
    assert len(reference.filled) == 2


def test_missing_accelerations_come_from_the_velocities() -> None:
    reference = read_reference(points(acceleration=EMPTY), ["a", "b"])
    np.testing.assert_allclose(reference.qdd, smooth(T)[2], atol=0.02)
    assert reference.filled == ("accelerations by a spline through the velocities",)


def test_two_points_make_the_rest_to_rest_motion() -> None:
    reference = read_reference(Points(["a"], [0.0, 1.0], [[0.0], [1.0]], [[], []], [[], []]), ["a"])
    q, qd, _ = reference.sample(np.array([0.5]))
    np.testing.assert_allclose(q, 0.5, atol=1e-9)
    np.testing.assert_allclose(qd, 15.0 / 8.0, atol=1e-9)


def test_a_set_point_lacks_zeros() -> None:
    reference = read_reference(Points(["a"], [0.0], [[0.3]], [[]], [[]]), ["a"])
    assert reference.is_setpoint
    assert not reference.qd.any()
    np.testing.assert_array_equal(reference.sample(np.array([0.0, 9.0]))[0], [[0.3], [0.3]])
    assert len(reference.filled) == 2


NAN = [[0.0, 0.0] for _ in T]
NAN[7] = [0.0, float("nan")]
SHORT = [[0.0, 0.0] for _ in T]
SHORT[3] = [0.0]


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"names": ["a", "c"]}, "no joint b; it moves a, c"),
        ({"names": []}, "no joint a, b"),
        ({"names": ["a", "a"]}, "twice"),
        ({"time": [], "position": [], "velocity": [], "acceleration": []}, "0 points"),
        ({"time": [0.0] * 41}, "must increase; point 1"),
        ({"time": [-1.0, *T[1:]]}, "not negative"),
        ({"time": [float("nan"), *T[1:]]}, "finite"),
        ({"time": [1e4 * t for t in T]}, "is time_from_start in seconds?"),
        ({"position": EMPTY}, "no positions"),
        ({"position": NAN}, "position of b in point 7 is nan"),
        ({"velocity": NAN}, "velocity of b in point 7 is nan"),
        ({"acceleration": SHORT}, "point 3 has 1 acceleration values for 2 joints"),
    ],
)
def test_what_cannot_be_followed_is_refused_by_name(changes: Any, expected: str) -> None:
    with pytest.raises(RefusedReference) as refusal:
        read_reference(points(**changes), ["a", "b"])
    assert expected in str(refusal.value)


def test_too_many_points_and_a_lonely_late_point_are_refused() -> None:
    with pytest.raises(RefusedReference, match="41 points; expected 1 to 40"):
        read_reference(points(), ["a", "b"], max_points=40)
    with pytest.raises(RefusedReference, match="has no start"):
        read_reference(Points(["a"], [2.0], [[0.0]], [[]], [[]]), ["a"])


SECOND = 1_000_000_000
TOLERANCE = 0.05


def move(begin: float, end: float, start: float, effort: float | None = None) -> Segment:
    """Return a motion from rest to rest in one second."""
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
        (move(0.0, 1.0, -0.5), r"jump by 0.5000 rad.*0.500 s after its start: send it earlier"),
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


def test_a_path_of_accelerations_alone_is_refused() -> None:
    table = [[0.0], [1.0]]
    alone = Points(["a"], [0.0, 1.0], table, [[], []], table)
    with pytest.raises(RefusedReference, match="no velocities"):
        read_path(alone, ["a"])
