"""Reading serialised joint states agrees with rclpy's own serialisation."""

import math
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from lagrangian_ff.nodes.common.joint_state_bytes import (
    JointStateMaker,
    JointStateReader,
    MessageError,
)
from lagrangian_ff.nodes.common.topics import nanoseconds

State = tuple[list[str], list[float], list[float], list[float]]


def message(
    name: list[str], position: list[float], velocity: list[float], effort: list[float],
    frame: str = "",
) -> bytes:  # fmt: skip
    joint_state = JointState(name=name, position=position, velocity=velocity, effort=effort)
    joint_state.header.frame_id = frame
    joint_state.header.stamp.sec = 3
    joint_state.header.stamp.nanosec = 7
    return bytes(serialize_message(joint_state))


@st.composite
def states(draw: st.DrawFn) -> State:
    text = st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=1, max_size=9)
    names = draw(st.lists(text, min_size=1, max_size=5, unique=True))
    full = st.lists(st.floats(width=64), min_size=len(names), max_size=len(names))
    absent: st.SearchStrategy[list[float]] = st.just([])
    values = st.one_of(absent, full)
    return names, draw(values), draw(values), draw(values)


@given(st.lists(st.tuples(states(), st.text("xyz", max_size=4)), max_size=4))
def test_one_reader_reads_what_was_serialised(sent: list[tuple[State, str]]) -> None:
    reader = JointStateReader()
    for (name, position, velocity, effort), frame in [*sent, *reversed(sent)]:
        view = reader.read(message(name, position, velocity, effort, frame))
        assert view.names == tuple(name)
        assert view.stamp == 3_000_000_007
        np.testing.assert_array_equal(view.position, position)
        np.testing.assert_array_equal(view.velocity, velocity)
        np.testing.assert_array_equal(view.effort, effort)


@given(st.binary(max_size=200))
def test_junk_is_a_message_error_and_leaves_the_reader_usable(junk: bytes) -> None:
    reader = JointStateReader()
    good = message(["a"], [1.0], [], [])
    reader.read(good)
    with suppress(MessageError):
        reader.read(junk)
    assert reader.read(good).names == ("a",)


@given(st.integers(0, 200))
def test_a_message_cut_off_anywhere_is_an_error(length: int) -> None:
    whole = message(["left", "right"], [1.0, 2.0], [3.0, 4.0], [5.0, 6.0], "base")
    reader = JointStateReader()
    reader.read(whole)
    cut = whole[: min(length, len(whole) - 1)]
    with pytest.raises(MessageError):
        reader.read(cut)


@pytest.mark.parametrize(
    ("state", "expected"),
    [
        (([], [], [], []), "no joints"),
        ((["a", "a"], [0.0, 1.0], [], []), "twice"),
        ((["a", "b"], [0.0], [], []), "1 values for 2 joints"),
        ((["a"], [0.0], [1.0, 2.0], []), "2 values for 1 joints"),
    ],
)
def test_malformed_messages_say_why(state: State, expected: str) -> None:
    with pytest.raises(MessageError, match=expected):
        JointStateReader().read(message(*state))


@pytest.mark.parametrize(
    ("state", "expected"),
    [
        ((["a", "b"], [0.0, 1.0], [], [math.nan, 1.0]), ""),
        ((["a", "b"], [], [], []), "a, b without positions"),
        ((["a", "b"], [0.0, math.inf], [], []), "position of b is not finite"),
    ],
)
def test_faults_of_positions_are_named(state: State, expected: str) -> None:
    fault = JointStateReader().read(message(*state)).fault()
    assert expected in fault
    assert bool(expected) == bool(fault)


@pytest.mark.parametrize("joints", [("a",), ("base", "elbow"), ("j_1", "j_2", "j_3", "j_4", "j_5")])
def test_a_joint_state_is_read_as_it_was_filled_in(joints: tuple[str, ...]) -> None:
    maker = JointStateMaker(joints)
    random = np.random.default_rng(0)
    for at in (5, 1_795_385_495_581_352_713):
        position, velocity, effort = random.normal(size=(3, len(joints)))
        velocity[0] = np.nan
        message = deserialize_message(maker.fill(at, position, velocity, effort), JointState)
        assert nanoseconds(message.header.stamp) == at
        assert tuple(message.name) == joints
        np.testing.assert_array_equal(message.position, position)
        np.testing.assert_array_equal(message.velocity, velocity)
        np.testing.assert_array_equal(message.effort, effort)
