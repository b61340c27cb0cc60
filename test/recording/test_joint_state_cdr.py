"""The CDR code against the library `rosbags`, which was written independently."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from recording_examples import decoded, equal, message

from lagrangian_ff.recording.joint_state import JointStateEncoder, JointStateTable

NAMES = st.lists(st.text("abcd_12é", min_size=1, max_size=9), min_size=1, max_size=5, unique=True)


@st.composite
def states(draw: st.DrawFn) -> tuple[int, list[str], list[list[float]]]:
    names = draw(NAMES)
    column = st.lists(st.floats(width=64), min_size=len(names), max_size=len(names))
    values = [
        draw(column),
        draw(st.one_of(st.just([]), column)),
        draw(st.one_of(st.just([]), column)),
    ]
    return draw(st.integers(0, 2**31 * 10**9 - 1)), names, values


@given(st.lists(states(), max_size=8))
def test_any_mixture_of_messages_is_read(
    given_states: list[tuple[int, list[str], list[list[float]]]],
) -> None:
    table = JointStateTable()
    for stamp, names, values in given_states:
        table.add(stamp + 5, message(stamp, names, *values))
    joints, stamps, received, *arrays = table.finish()
    assert list(stamps) == [stamp for stamp, _, _ in given_states]
    assert list(received) == [stamp + 5 for stamp, _, _ in given_states]
    assert set(joints) == {name for _, names, _ in given_states for name in names}
    for row, (_, names, values) in enumerate(given_states):
        for array, value in zip(arrays, values, strict=True):
            expected = np.full(len(joints), np.nan)
            for name, number in zip(names, value, strict=False):
                expected[joints.index(name)] = number
            assert equal(array[row], expected)


@given(states())
def test_what_is_written_the_library_reads(state: tuple[int, list[str], list[list[float]]]) -> None:
    stamp, names, values = state
    encoder = JointStateEncoder(tuple(names), velocity=bool(values[1]), effort=bool(values[2]))
    rows = [np.array([value]) for value in values]
    (data,) = encoder.encode(np.array([stamp]), *rows)
    found = decoded(data)
    assert found.header.stamp.sec * 10**9 + found.header.stamp.nanosec == stamp
    assert found.name == names
    for array, value in zip((found.position, found.velocity, found.effort), values, strict=True):
        assert equal(array, np.array(value))


@given(st.binary(max_size=120), states(), st.integers(0, 200))
def test_broken_bytes_are_counted_and_never_raise(
    noise: bytes, state: tuple[int, list[str], list[list[float]]], cut: int
) -> None:
    whole = message(state[0], state[1], *state[2])
    table = JointStateTable()
    table.add(0, noise)
    table.add(0, whole[: min(cut, len(whole) - 1)])
    table.add(0, whole)
    assert table.malformed + len(table) == 3
    assert table.finish()[1][-1] == state[0]


def test_big_endian_messages_are_read() -> None:
    little = message(7, ["a"], [1.5], [2.5], [3.5])
    big = bytearray(little)
    big[1] = 0
    words = [4, 8, 12, 28, 32, 40, 52, 68]  # stamp, text lengths and counts
    for at in words:
        big[at : at + 4] = big[at : at + 4][::-1]
    for at in (44, 60, 76):
        big[at : at + 8] = big[at : at + 8][::-1]
    table = JointStateTable()
    table.add(0, bytes(big))
    joints, stamps, _, position, velocity, effort = table.finish()
    assert joints == ("a",)
    assert stamps[0] == 7
    assert (position[0, 0], velocity[0, 0], effort[0, 0]) == (1.5, 2.5, 3.5)


def test_rewinding_forgets_what_came_after_the_mark() -> None:
    table = JointStateTable()
    table.add(1, message(1, ["a"], [1.0]))
    mark = table.mark()
    table.add(2, b"broken")
    table.add(2, message(2, ["a"], [2.0]))
    assert len(table) == 2
    table.rewind(mark)
    table.add(3, message(3, ["a"], [3.0]))
    _, stamps, _, position, *_ = table.finish()
    assert list(stamps) == [1, 3]
    assert list(position[:, 0]) == [1.0, 3.0]
    assert table.malformed == 0
