"""The stretches of motions that are learned from, and those that confirm."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.investigation.stretches import STRETCH, learned_and_unseen
from lagrangian_ff.recording import Motion, concatenate


@given(seconds=st.lists(st.floats(2.0, 40.0), min_size=1, max_size=3))
def test_what_is_learned_from_lies_all_along_each_motion(seconds: list[float]) -> None:
    motions = [still(round(100 * one)) for one in seconds]
    learned, unseen = learned_and_unseen(motions)
    assert len(learned) == len(unseen)
    assert sum(map(len, learned)) + sum(map(len, unseen)) == sum(map(len, motions))
    for a, b in zip(learned, unseen, strict=True):
        assert a.time[-1] < b.time[0]
        assert b.time[-1] - a.time[0] <= 1.5 * STRETCH
        assert len(a) / (len(a) + len(b)) == pytest.approx(0.6, abs=0.01)
    joined = concatenate(learned)
    assert len(np.unique(joined.segment)) == len(learned)


def still(count: int) -> Motion:
    zero = np.zeros((count, 1))
    time = np.arange(count) / 100.0
    return Motion(("a",), time, zero, zero, zero, zero, np.zeros(count, dtype=np.int64))
