"""The cases, the same from the same seed and broad enough; and the plants made of them."""

import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from lagrangian_ff.arm import JOINTS, check_limits
from lagrangian_ff.arm.hidden import HIDDEN
from lagrangian_ff.studies.hidden.cases import MOTIONS, SIZES, Hidden, HiddenCase, cases
from lagrangian_ff.studies.hidden.plants import Plant, Stretches, motion, recorded

SHORT = Stretches(((6, 4.0),))


def test_the_same_seed_gives_the_same_cases() -> None:
    assert cases(3) == cases(3)
    assert cases(3) != cases(4)
    assert cases(3, small=True) == cases(3, small=True)


def test_names_are_unique_and_of_one_physics_over_all_sizes() -> None:
    every = cases()
    assert len({case.name for case in every}) == len(every)
    plants: dict[str, set[tuple[int, int]]] = {}
    for case in every:
        if case.group == "alone":
            stem = case.name.rpartition("-")[0]
            plants.setdefault(stem, set()).add((case.motion, case.seed))
    assert all(len(found) == 1 for found in plants.values())


def test_every_effect_is_hidden_on_several_joints_at_every_plausible_size() -> None:
    sizes: dict[str, set[float]] = {}
    joints: dict[str, set[str]] = {}
    for case in cases():
        if len(case.hidden) == 1:
            (hidden,) = case.hidden
            assert hidden.joint in JOINTS
            assert JOINTS.index(hidden.joint) in hidden.kind.joints
            sizes.setdefault(hidden.effect, set()).add(hidden.size)
            joints.setdefault(hidden.effect, set()).add(hidden.joint)
    assert set(sizes) == set(HIDDEN)
    for name, effect in HIDDEN.items():
        assert sizes[name] == {size for size in SIZES if size <= effect.largest}
        assert len(joints[name]) >= 2
        assert {JOINTS.index(joint) < 3 for joint in joints[name]} == {True, False}


def test_there_are_clean_plants_pairs_and_strangers_in_both_versions() -> None:
    for small, least in ((False, 6), (True, 1)):
        groups = Counter(case.group for case in cases(small=small))
        assert set(groups) == {"clean", "alone", "pair", "outside"}
        assert min(groups.values()) >= least
        assert {case.motion for case in cases(small=small)} <= set(range(MOTIONS))


@pytest.fixture(scope="module")
def motions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder where runs of the arm without effects are kept."""
    return tmp_path_factory.mktemp("motions")


def test_a_case_becomes_two_recordings_of_one_plant(motions: Path) -> None:
    case = HiddenCase(
        "x", (Hidden("ripple", "joint_2", 0.2), Hidden("delay", "joint_5", 0.05)), 0, 3
    )
    first, second, plant = recorded(case, motions, SHORT)
    assert len(first) == len(second) == 2001
    assert not np.array_equal(first.position, second.position)
    ripple, delay = plant.hidden
    assert ripple.reached[0] == pytest.approx(0.2, rel=0.2)
    assert delay.reached[0] == pytest.approx(0.05, rel=0.3)
    assert 0.0 < ripple.visible[0] <= ripple.reached[0] + 1e-9
    assert (ripple.catalogue, ripple.joints) == (["ripple"], ["joint_2"])
    assert Plant.of(json.loads(json.dumps(plant.record()))) == plant
    again = recorded(case, motions, SHORT)
    np.testing.assert_array_equal(again[0].effort, first.effort)
    assert again[2] == plant


def test_both_recordings_are_of_one_arm(motions: Path) -> None:
    case = HiddenCase("x", (Hidden("saturation", "joint_2", 0.2),), 0, 3)
    first, second, plant = recorded(case, motions, SHORT)
    limit = plant.hidden[0].facts["limit [N·m]"]
    noise = 160.0 * 0.0385 * 0.12
    for recording in (first, second):
        assert limit < np.abs(recording.effort[:, 1]).max() < limit + 6.0 * noise


def test_motions_are_joined_at_rest_within_the_limits() -> None:
    whole = motion(0, 1, Stretches(((2, 4.0), (6, 4.0))))
    assert whole.duration == pytest.approx(8.0)
    check_limits(whole)
    np.testing.assert_allclose(whole.sample(4.0)[1], 0.0, atol=1e-9)
    slow, fast = (np.abs(whole.qd[part]).mean() for part in (slice(0, 400), slice(400, 800)))
    assert fast > 1.5 * slow
