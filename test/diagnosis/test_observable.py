"""What a motion could show: as `diagnose` says it, less with less motion, and true when tried."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import two_rods
from hypothesis import given, settings
from hypothesis import strategies as st
from whitened_examples import few_torques

from lagrangian_ff.diagnosis import Verdict, diagnose
from lagrangian_ff.diagnosis.observable import Observability, observability
from lagrangian_ff.diagnosis.thresholds import USED
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.recording.motion import WITHOUT_FRICTION, Motion

FEW = Settings(train=1.0, samples=120, evaluations=20)
MUCH = 40.0  # s


_small = few_torques(1200)


@cache
def rods(seed: int = 1, seconds: float = MUCH) -> Observability:
    """Return what a motion of the two rods could show."""
    return observability(two_rods.motion(seed, seconds))


def test_it_says_what_diagnose_says_of_the_same_motion() -> None:
    """But for effects near the limit: a model was learned, and its friction is refitted."""
    motion = two_rods.motion(1)
    found = diagnose(identify(motion, FEW).model, motion, two_rods.motion(2))
    assert not found.findings
    hidden = {(one.effect, one.joint) for one in found.not_observable}
    mine = rods()
    assert {(one.effect, one.joint) for one in mine.not_observable if one.joint == "all"} == {
        (one.effect, one.joint) for one in found.not_observable if one.joint == "all"
    }
    for effect, row in mine.least.items():
        for joint, least in zip(mine.joints, row, strict=True):
            if not USED.observable_size / 1.25 < least < 1.25 * USED.observable_size:
                assert ((effect, joint) in hidden) == (least > USED.observable_size), effect
    said = {(one.effect, one.joint): one for one in mine.not_observable}
    for one in found.not_observable:
        if (one.effect, one.joint) in said:
            assert said[one.effect, one.joint].next_motion == one.next_motion


@settings(max_examples=4, deadline=None)
@given(st.integers(1, 6))
def test_more_motion_shows_hardly_less(seed: int) -> None:
    """A motion and its beginning: what is seen at a size in half is seen in all of it."""
    half, whole = rods(seed, MUCH / 2), rods(seed, MUCH)
    for effect, row in half.least.items():
        less, more = np.array(row), np.array(whole.least[effect])
        assert (more < 1.25 * less).all(), (effect, less, more)


def test_a_joint_that_stands_still_shows_nothing() -> None:
    motion = two_rods.motion(1)
    q, qd, qdd = (one * [1.0, 0.0] for one in (motion.q, motion.qd, motion.qdd))
    tau = two_rods.rods(q, qd, qdd) + two_rods.NOISE * np.random.default_rng(0).normal(size=q.shape)
    found = observability(replace(motion, q=q, qd=qd, qdd=qdd, tau=tau))
    assert all(np.isinf(row[1]) for row in found.least.values())
    assert any(np.isfinite(row[0]) for row in found.least.values())
    elbow = {one.effect: one.reason for one in found.not_observable if one.joint == "elbow"}
    assert set(elbow) == set(found.least)
    assert set(elbow.values()) == {"elbow stands still"}
    assert all("elbow" not in found.shown(effect) for effect in found.least)


@pytest.mark.parametrize(("times", "seen"), [(2.5, True), (1.0 / 3.0, False)])
@pytest.mark.parametrize("effect", ["quadratic_drag", "ripple"])
def test_the_least_size_is_the_one_that_diagnose_needs(
    effect: str, times: float, seen: bool
) -> None:
    least = rods().least[effect][1]
    first, second = (with_effect(effect, times * least, seed) for seed in (1, 2))
    found = diagnose(identify(first, FEW).model, first, second)
    claims = [(one.effect.name, one.joint) for one in found.findings]
    named = [(o.effect.name, o.joint) for o in found.findings if o.verdict is Verdict.CONFIRMED]
    assert ((effect, "elbow") in claims) == seen, claims
    assert named in ([], [(effect, "elbow")])


def with_effect(effect: str, share: float, seed: int) -> Motion:
    """Return a motion whose elbow has an effect of a share of its torque's spread."""
    motion = two_rods.motion(seed)
    qd, q = motion.qd[:, 1], motion.q[:, 1]
    form = {"quadratic_drag": qd * np.abs(qd), "ripple": np.sin(11.0 * q)}[effect]
    size = share * motion.tau[:, 1].std() / np.sqrt(np.mean(form**2))
    return replace(motion, tau=motion.tau + np.stack([0.0 * form, size * form], axis=1))


def test_several_motions_show_more_than_one() -> None:
    one = rods(1, 20.0)
    both = observability([two_rods.motion(seed, 20.0) for seed in (1, 2)])
    better = [b < a for e in one.least for a, b in zip(one.least[e], both.least[e], strict=True)]
    assert np.mean(better) > 0.9


def test_its_words_and_its_record_count_the_same() -> None:
    found = rods()
    record = found.record()
    assert record["words"] == found.words
    counts = [len(found.shown(effect)) for effect in found.least]
    assert f"{counts.count(2)} of {len(counts)} on every joint" in found.words
    assert set(found.least) < set(EFFECTS)
    assert not {"viscous", "coulomb", "offset"} & set(found.least)


def test_where_the_drive_compensates_friction_only_plain_friction_is_looked_for() -> None:
    motion = replace(two_rods.motion(1, 20.0), conditioning={"effort": WITHOUT_FRICTION})
    found = observability(motion)
    assert {"viscous", "coulomb"} <= set(found.least)
    assert "stribeck" not in found.least


def test_too_little_motion_is_refused() -> None:
    with pytest.raises(RecordingError, match="expected at least 2 s"):
        observability(two_rods.motion(1, 1.0))
