"""Unseen motion is judged in groups of pieces: each expects enough, and there are many."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrangian_ff.diagnosis.search.confirm import GROUP_NATS, GROUPS, MOST_GROUPS, grouped

HOPES = st.lists(st.floats(0.0, 30.0), min_size=1, max_size=120)


@settings(max_examples=200)
@given(HOPES)
def test_nothing_is_lost_and_no_group_expects_less_than_noise(hopes: list[float]) -> None:
    expected = np.array(hopes)
    gained = np.cos(np.arange(len(expected))) * expected
    sums, hoped = grouped(gained, expected)
    assert len(sums) <= MOST_GROUPS
    if len(sums):
        assert np.all(hoped >= GROUP_NATS[0])
        np.testing.assert_allclose([sums.sum(), hoped.sum()], [gained.sum(), expected.sum()])
    else:
        assert expected.sum() < GROUP_NATS[1]


def test_bursts_do_not_make_the_groups_fewer() -> None:
    even = np.full(120, 1.5)
    bursts = np.zeros(120)
    bursts[::10] = 15.0
    for expected in (even, bursts):
        assert expected.sum() == 180.0
        assert len(grouped(expected, expected)[0]) >= GROUPS
    assert len(grouped(bursts, bursts)[0]) == MOST_GROUPS
