"""The arms of the study: what is drawn, how often, and that it is in their recordings."""

import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from lagrangian_ff.arm import JOINTS
from lagrangian_ff.arm.hidden import HIDDEN
from lagrangian_ff.studies.hidden.cases import SIZES
from lagrangian_ff.studies.nuisances.drawn import CHANCES, GAIN, NAMES, Nuisances
from lagrangian_ff.studies.nuisances.plants import NuisancePlant, cases, recorded

DRAWN = [Nuisances.draw(seed) for seed in range(400)]


def test_most_arms_have_several_nuisances_and_each_nuisance_has_arms_without() -> None:
    present = [one.present for one in DRAWN]
    for name, chance in CHANCES.items():
        share = np.mean([one[name] for one in present])
        assert share == pytest.approx(0.73 if name == "rest" else chance, abs=0.08)
    assert np.mean([sum(one.values()) >= 3 for one in present]) > 0.8


def test_the_amounts_are_those_of_real_arms() -> None:
    assert all(8.0 <= one.seconds <= 60.0 and 90.0 <= one.rate <= 5000.0 for one in DRAWN)
    assert all(one.rest == 0.0 or 0.1 <= one.rest <= 0.4 for one in DRAWN)
    assert all(one.rest for one in DRAWN if one.motion == "point-to-point")
    assert max(abs(gain - 1.0) for one in DRAWN for gain in one.gains) == pytest.approx(
        GAIN, rel=0.05
    )
    assert 0.009 < max(one.delay for one in DRAWN) <= 0.01
    assert {one.motion for one in DRAWN} == {"point-to-point", "fourier", "spline"}
    assert DRAWN[3] == Nuisances.draw(3)
    assert Nuisances.of(json.loads(json.dumps(DRAWN[3].record()))) == DRAWN[3]


def test_what_is_there_may_be_named_on_all_joints() -> None:
    for one in DRAWN[:50]:
        allowed = {truth.names for truth in one.allowed}
        assert allowed == {names for name, names in NAMES.items() if one.present[name]}
        assert all(truth.joints == JOINTS for truth in one.allowed)


def test_a_fifth_of_the_arms_hide_nothing_and_a_fifth_something_strange() -> None:
    every = cases()
    assert len(every) >= 300
    assert len({case.name for case in every}) == len(every)
    groups = Counter(case.group for case in every)
    assert groups["clean"] == groups["outside"] == len(every) / 5
    # A study that is stopped early has all groups, too.
    assert set(Counter(case.group for case in every[:10])) == set(groups)
    sizes = Counter(case.hidden[0].size for case in every if case.group == "alone")
    assert set(sizes) == set(SIZES)
    hidden = [one for case in every for one in case.hidden]
    assert {one.effect for one in hidden} == set(HIDDEN)
    assert all(one.size <= one.kind.largest for one in hidden)
    assert cases() == every != cases(1)
    assert 8 <= len(cases(small=True)) <= 12


def test_a_case_becomes_two_recordings_of_one_arm_and_is_kept(tmp_path: Path) -> None:
    case = next(case for case in cases() if case.name.startswith("stribeck"))
    first, second, plant = recorded(case, tmp_path, keep=True, longest=7.0)
    assert first.joints == second.joints == JOINTS
    assert not np.array_equal(first.position, second.position)
    assert plant.nuisances == Nuisances.of(
        {**Nuisances.draw(case.seed).record(), "seconds": plant.nuisances.seconds}
    )
    assert plant.hidden[0].reached[0] == pytest.approx(case.hidden[0].size, rel=0.3)
    assert all(0.4 * a < b <= a for a, b in zip(plant.seconds, plant.moving, strict=True))
    again = recorded(case, tmp_path, keep=True, longest=7.0)
    np.testing.assert_array_equal(again[0].effort, first.effort)
    assert again[2] == plant == NuisancePlant.of(json.loads(json.dumps(plant.record())))
