"""The list of cases: the same from the same seed, and broad enough."""

from collections import Counter

from lagrangian_ff.arm import JOINTS
from lagrangian_ff.arm.hidden import HIDDEN
from lagrangian_ff.studies.hidden.cases import MOTIONS, SIZES, cases


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
