"""Curves as effects: the splines that they are made of, and what they are outside."""

import json
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from lagrangian_ff.effects import EFFECTS, Curve, Inputs, Over, curve_over, effect_of
from lagrangian_ff.effects.curve import FADES, KINDS, Axis, curve_named, from_stored
from lagrangian_ff.effects.user import check, trial_motion
from lagrangian_ff.errors import EffectError
from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]

STEPS = st.lists(st.floats(0.05, 3.0), min_size=1, max_size=12)
"""Distances between bends."""


def axis_of(steps: list[float]) -> Axis:
    return Axis(tuple(np.cumsum([-1.0, *steps]).tolist()))


def at(q: Floats, qd: Floats | None = None) -> Inputs:
    """Return states of two joints whose first is at q."""
    both = np.stack([q, q], axis=1)
    return Inputs.of(States.of(both, 0.0 * both if qd is None else np.stack([qd, qd], 1), both))


def example(over: tuple[str, ...] = ("position",), seed: int = 0, **how: bool) -> Curve:
    """Return a curve with heights drawn at random, two directions."""
    axes = tuple(Axis(tuple(np.linspace(-1.0, 1.0, 5).tolist())) for _ in over)
    count = int(np.prod([axis.count for axis in axes]))
    heights = np.random.default_rng(seed).normal(size=(count, 2))
    made = curve_over([Over.of(one, ("a", "b", "c")) for one in over], **how)
    return made.made(axes, np.ones(count, dtype=bool), heights)


@given(STEPS, st.floats(-1.0, 40.0))
def test_splines_add_up_to_one_and_are_those_of_scipy(steps: list[float], place: float) -> None:
    axis = axis_of(steps)
    inside = np.array([min(place, axis.bends[-1])])
    first, values = axis.weights(inside)
    assert values.sum() == pytest.approx(1.0)
    assert (values >= -1e-12).all()
    known = BSpline(axis.knots, np.eye(axis.count), 3)(inside)[0]
    found = np.zeros(axis.count)
    found[first[0] : first[0] + 4] = values[0]
    np.testing.assert_allclose(found, known, atol=1e-9)


@given(STEPS)
def test_a_curve_is_smooth_inside_and_falls_to_zero_without_a_jump(steps: list[float]) -> None:
    axis = axis_of(steps)
    low, high = axis.bends[0], axis.bends[-1]
    width = high - low
    q = np.linspace(low - 0.3 * width, high + 0.3 * width, 20_000)
    heights = np.random.default_rng(1).uniform(-1.0, 1.0, size=(axis.count, 1))
    made = curve_over([Over("position")]).made((axis,), np.ones(axis.count, dtype=bool), heights)
    torque = made.columns(at(q), 0, {})[:, 0]
    beyond = (q < low - FADES * width) | (q > high + FADES * width)
    assert not torque[beyond].any()
    assert made.outside(at(q), 0)[(q < low) | (q > high)].all()
    assert not made.outside(at(q), 0)[(q >= low) & (q <= high)].any()
    steepest = 3.0 / min(min(steps), FADES * width)  # of splines and of the fade
    assert np.abs(np.diff(torque)).max() <= 2.0 * steepest * (q[1] - q[0])


def test_a_place_that_nothing_was_seen_in_is_outside_too() -> None:
    whole = example(("position", "velocity"))
    seen = np.ones((7, 7), dtype=bool)
    seen[4:, 4:] = False  # the far corner
    made = whole.made(whole.axes, seen.ravel(), whole.heights * seen.ravel()[:, None])
    q = np.array([-0.6, 0.99, 0.99, -0.99])
    qd = np.array([-0.6, 0.99, -0.99, 0.99])
    x = at(q, qd)
    assert made.outside(x, 0).tolist() == [False, True, False, False]
    assert np.abs(made.columns(x, 0, {})[1]).max() < 0.1


@given(st.integers(0, 99))
def test_friction_changes_sign_with_direction_and_nothing_else(seed: int) -> None:
    q, qd = np.random.default_rng(seed).uniform(-1.0, 1.0, (2, 50))
    plain, friction = example(seed=seed), example(seed=seed, friction=True)
    x = at(q, qd)
    expected = plain.columns(x, 0, {}) * x.sign(0)[:, None]
    np.testing.assert_allclose(friction.columns(x, 0, {}), expected)


def test_a_curve_reads_its_own_joint_or_another_one() -> None:
    x = trial_motion()
    own, other = example(("position",)), example(("position@c",))
    np.testing.assert_array_equal(own.columns(x, 2, {}), other.columns(x, 0, {}))
    assert not np.allclose(own.columns(x, 0, {}), other.columns(x, 0, {}))


@pytest.mark.parametrize("kind", KINDS)
def test_a_curve_is_sound_over_everything_and_its_name_says_what_it_is(kind: str) -> None:
    for made in (example((kind,)), example((kind, f"{kind}@b"), friction=True)):
        check(made)
        known = curve_named(made.name)
        assert known is not None
        assert [(one.kind, one.joint) for one in known.over] == [
            (one.kind, one.joint) for one in made.over
        ]
        assert (known.part, known.kind, known.friction) == (made.part, made.kind, made.friction)
        assert effect_of(made.name) is not None
    assert effect_of("stribeck") is EFFECTS["stribeck"]
    assert effect_of("curved") is None


def test_a_stored_curve_is_the_same_curve() -> None:
    for made in (example(("load", "position@b"), friction=True), example(odd=True)):
        x = trial_motion()
        kept = from_stored(json.loads(json.dumps(made.stored())), ("a", "b", "c"))
        for same in (kept, pickle.loads(pickle.dumps(made))):
            np.testing.assert_array_equal(same.columns(x, 0, {}), made.columns(x, 0, {}))
            assert same.stored() == made.stored()
        assert kept.meaning == made.meaning


def test_a_curve_that_is_not_made_goes_to_another_process() -> None:
    wish = curve_over([Over("velocity")], odd=True)
    same = pickle.loads(pickle.dumps(wish))
    assert (same.over, same.odd, same.axes) == (wish.over, wish.odd, ())


@pytest.mark.parametrize(
    "wrong",
    [
        {"over": []}, {"over": ["time"]}, {"over": ["position9"]}, {"bends": [[1.0, 0.0]]},
        {"bends": [[0.0, float("nan"), 1.0]]}, {"heights": [[1.0]]}, {"seen": [1]},
        {"bends": []}, {"heights": [[float("inf")] * 2] * 7},
    ],
)  # fmt: skip
def test_what_is_no_curve_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="curve"):
        from_stored({**example().stored(), **wrong}, ("a", "b", "c"))


@pytest.mark.parametrize(
    ("over", "how", "words"),
    [
        ((), {}, "one or two"),
        (("position", "velocity", "load"), {}, "one or two"),
        (("position", "position"), {}, "different"),
        (("position", "velocity"), {"monotone": True}, "monotone"),
        (("time",), {}, "expected one or two of position"),
        (("position@elbow",), {}, "has the joints a, b, c"),
    ],
)
def test_what_cannot_be_a_curve_is_said(
    over: tuple[str, ...], how: dict[str, bool], words: str
) -> None:
    with pytest.raises(EffectError, match=words):
        curve_over([Over.of(one, ("a", "b", "c")) for one in over], **how)


def test_the_table_of_a_curve_is_what_it_adds() -> None:
    made, b = example(), np.array([0.7, -1.2])
    (places,), torque = made.table(b, 30)
    np.testing.assert_allclose(torque, made.columns(at(places), 0, {}) @ b, atol=1e-12)
    assert "position from -1 to 1 rad" in made.words(b)
