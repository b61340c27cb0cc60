"""Hold-out motion is cut into many groups, and enough is expected of each."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import wilcoxon

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.search.hold_out import grouped, signed_ranks

HOPES = st.lists(st.floats(0.0, 30.0), min_size=1, max_size=120)


@settings(max_examples=200)
@given(HOPES)
def test_nothing_is_lost_and_no_group_expects_less_than_noise(hopes: list[float]) -> None:
    expected = np.array(hopes)
    gained = np.cos(np.arange(len(expected))) * expected
    sums, hoped = grouped(gained, expected)
    assert len(sums) <= thresholds.USED.most_groups
    if len(sums):
        assert np.all(hoped >= thresholds.USED.group_nats[0])
        np.testing.assert_allclose([sums.sum(), hoped.sum()], [gained.sum(), expected.sum()])
    else:
        assert expected.sum() < thresholds.USED.group_nats[1]


def test_bursts_do_not_make_the_groups_fewer() -> None:
    even = np.full(120, 1.5)
    bursts = np.zeros(120)
    bursts[::10] = 15.0
    for expected in (even, bursts):
        assert expected.sum() == 180.0
        assert len(grouped(expected, expected)[0]) >= thresholds.USED.groups
    assert len(grouped(bursts, bursts)[0]) == thresholds.USED.most_groups


def test_what_shows_mostly_in_one_place_is_judged_in_the_others_too() -> None:
    expected = np.array([1500.0, 600.0, *np.full(8, 20.0)])
    sums, hoped = grouped(-expected, expected)
    assert thresholds.USED.fewest_groups <= len(sums) <= thresholds.USED.most_groups
    assert hoped.min() >= 20.0
    few = np.array([1500.0, 600.0, 1.0, 1.0])
    assert len(grouped(few, few)[0]) < thresholds.USED.fewest_groups


@given(st.lists(st.integers(-1000, 1000), min_size=5, max_size=8, unique_by=abs))
def test_signed_ranks_are_wilcoxons(gains: list[int]) -> None:
    few = np.array([0.1 * one for one in gains if one != 0])
    expected = wilcoxon(few, alternative="greater", method="exact").pvalue
    np.testing.assert_allclose(signed_ranks(few), expected, rtol=1e-12)
