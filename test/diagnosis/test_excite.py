"""The motions: within limits, smooth, from rest to rest, and what each is for."""

from functools import lru_cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.excite import NEXT_MOTIONS, Limits, Reference, excite
from lagrangian_ff.diagnosis.excite.path import GRID, Path
from lagrangian_ff.effects import EFFECTS, MOTIONS
from lagrangian_ff.errors import ModelError

Floats = NDArray[np.float64]

JOINTS = ("a", "b", "c")
LIMITS = Limits(
    np.array([-1.5, -0.8, 0.2]),
    np.array([1.5, 1.0, 0.7]),
    np.array([2.0, 3.0, 1.0]),
    np.array([8.0, 20.0, 5.0]),
)


@lru_cache(maxsize=64)
def made(motion: str, joint: str | None = None, seconds: float | None = None) -> Reference:
    """One of the motions within the limits above."""
    return excite(motion, JOINTS, LIMITS, joint=joint, duration=seconds)


def runs(values: Floats, length: int) -> list[float]:
    """The values that stay the same, other than zero, for so many samples."""
    found, begin = [], 0
    for k in range(1, len(values) + 1):
        if k == len(values) or abs(values[k] - values[begin]) > 1e-9:
            if k - begin >= length and abs(values[begin]) > 1e-9:
                found.append(float(values[begin]))
            begin = k
    return found


def test_every_effect_has_its_motion() -> None:
    assert set(NEXT_MOTIONS) == set(MOTIONS)
    assert {effect.motion for effect in EFFECTS.values()} <= set(NEXT_MOTIONS)
    assert all(chosen.meaning and chosen.by_hand for chosen in NEXT_MOTIONS.values())


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("joint", [None, "b"])
@settings(max_examples=8)
@given(data=st.data())
def test_limits_are_kept(motion: str, joint: str | None, data: st.DataObject) -> None:
    """Whatever the limits, the start and the duration."""
    part = st.floats(0.0, 1.0)
    low = np.array([data.draw(st.floats(-2.0, 0.0)) for _ in JOINTS])
    high = low + np.array([data.draw(st.floats(0.02, 4.0)) for _ in JOINTS])
    fast = np.array([data.draw(st.floats(0.2, 8.0)) for _ in JOINTS])
    hard = fast * np.array([data.draw(st.floats(1.0, 10.0)) for _ in JOINTS])
    limits = Limits(low, high, fast, hard)
    start, pose = (low + (high - low) * [data.draw(part) for _ in JOINTS] for _ in range(2))
    seconds = data.draw(st.floats(8.0, 60.0))
    found = excite(motion, JOINTS, limits, joint=joint, start=start, pose=pose, duration=seconds)
    slack = 1e-9
    assert np.all(found.q >= low - slack)
    assert np.all(found.q <= high + slack)
    assert np.all(np.abs(found.qd) <= fast + slack)
    assert np.all(np.abs(found.qdd) <= hard * (1 + 1e-6))
    for end in (0, -1):
        np.testing.assert_allclose(found.q[end], start, atol=1e-9)
        np.testing.assert_allclose(found.qd[end], 0.0, atol=1e-9)
        np.testing.assert_allclose(found.qdd[end], 0.0, atol=1e-6)


@pytest.mark.parametrize("motion", MOTIONS)
def test_derivatives_belong_together(motion: str) -> None:
    """Each step of q and qd is the integral of what drives it, to the third order of the grid."""
    time, q, qd, qdd = made(motion, "a")
    np.testing.assert_allclose(np.diff(time), GRID, atol=1e-9)
    step = np.diff(time)[:, None]
    by_rate = step * (qd[1:] + qd[:-1]) / 2 - step**2 * np.diff(qdd, axis=0) / 12
    np.testing.assert_allclose(np.diff(q, axis=0), by_rate, atol=2e-6)
    by_hardness = step * (qdd[1:] + qdd[:-1]) / 2
    assert np.abs(np.diff(qd, axis=0) - by_hardness).max() < 0.02


@pytest.mark.parametrize("motion", ["speeds", "slow sweep", "reversals", "chirp", "warm-up"])
def test_the_others_are_held(motion: str) -> None:
    found = made(motion, "b")
    assert np.ptp(found.q[:, 1]) > 0.0
    assert not np.ptp(found.q[:, [0, 2]], axis=0).any()


@pytest.mark.parametrize("motion", MOTIONS)
def test_all_joints_take_part(motion: str) -> None:
    assert np.all(np.ptp(made(motion).q, axis=0) > 0.0)


def test_speeds_are_constant_from_creeping_to_the_limit() -> None:
    speed = runs(made("speeds", "a").qd[:, 0], 5)
    forth, back = (sorted({round(s * v, 6) for v in speed if s * v > 0}) for s in (1, -1))
    assert forth == back
    assert len(forth) >= 6
    assert forth[0] == pytest.approx(0.005, rel=0.05)
    assert forth[-1] > 0.9 * LIMITS.qd_max[0]
    ratio = np.diff(np.log(forth))
    assert ratio.max() < 1.5 * np.median(ratio)


def test_a_slow_sweep_covers_the_range_with_many_samples_a_ripple() -> None:
    found = made("slow sweep", "a")
    q, qd = found.q[:, 0], found.qd[:, 0]
    assert np.ptp(q) == pytest.approx(3.0)
    fastest = max(map(abs, runs(qd, 200)))
    order = max(shape.high for shape in EFFECTS["ripple"].shapes)
    assert 2 * np.pi / order / (fastest * GRID) >= 20
    assert {0.005, 0.05} <= {round(abs(v), 3) for v in runs(qd, 50)}


def test_reversals_have_strokes_of_all_sizes_at_two_speeds() -> None:
    found = made("reversals", "a")
    q, qd = found.q[:, 0], found.qd[:, 0]
    turns = np.flatnonzero(np.diff(np.sign(qd[np.abs(qd) > 1e-12])))
    stroke = np.abs(np.diff(q[np.abs(qd) > 1e-12][turns]))
    for size in (1e-4, 1e-3, 1e-2, 0.15):
        assert np.any(np.abs(stroke / size - 1) < 0.1), size
    peaks = [abs(qd[a:b]).max() for a, b in pairwise(turns)]
    assert max(peaks) > 3 * np.median(peaks)


def test_a_chirp_gets_faster_and_stays_small() -> None:
    found = made("chirp", "a", 40.0)
    q, qd = found.q[:, 0] - found.q[0, 0], found.qd[:, 0]
    assert np.abs(q).max() < 0.1
    crossing = found.time[:-1][np.diff(np.sign(qd)) != 0]
    half = np.diff(crossing[crossing > 2.0])
    assert half.max() > 1.0
    assert half.min() < 0.08


def test_one_by_one_moves_each_alone_then_pairs_both_ways() -> None:
    qd = made("one by one", "a").qd
    moves = np.abs(qd) > 1e-6
    alone = [np.any(moves[:, n] & (moves.sum(axis=1) == 1)) for n in range(3)]
    assert all(alone)
    for other in (1, 2):
        both = moves[:, 0] & moves[:, other] & (moves.sum(axis=1) == 2)
        share = np.mean(qd[both, 0] * qd[both, other] > 0)
        assert 0.2 < share < 0.8
        ratio = np.abs(qd[both, other] / qd[both, 0])
        assert np.quantile(ratio, 0.9) > 2 * np.quantile(ratio, 0.1)


def test_a_warm_up_repeats_itself() -> None:
    found = made("warm-up", "a", 60.0)
    q = found.q[:, 0]
    apart = {lag: np.abs(q[100:3100] - q[100 + lag : 3100 + lag]).max() for lag in range(900, 2000)}
    period = next(lag for lag, most in apart.items() if most < 1e-9)
    assert len(q) > 4 * period


def test_exciting_covers_the_ranges_at_all_speeds() -> None:
    found = made("exciting")
    assert np.all(np.ptp(found.q, axis=0) > 0.85 * LIMITS.width)
    speed = np.abs(found.qd) / np.abs(found.qd).max(axis=0)
    assert np.all((speed < 0.05).mean(axis=0) > 0.05)
    assert np.all((speed > 0.5).mean(axis=0) > 0.05)
    assert np.all(np.abs(np.corrcoef(found.q.T) - np.eye(3)) < 0.5)
    other = excite("exciting", JOINTS, LIMITS, seed=1)
    assert np.abs(other.q[1000] - found.q[1000]).max() > 0.01
    np.testing.assert_array_equal(excite("exciting", JOINTS, LIMITS).q, found.q)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("seconds", [30.0, 90.0])
def test_it_lasts_about_as_long_as_asked(motion: str, seconds: float) -> None:
    assert 0.5 * seconds < made(motion, "a", seconds).time[-1] < 1.4 * seconds + 5.0


@given(way=st.floats(-3.0, 3.0).filter(lambda way: abs(way) > 1e-6), speed=st.floats(1e-3, 10.0))
def test_a_run_ends_where_it_should_and_is_no_faster(way: float, speed: float) -> None:
    wide = Limits(np.array([-3.0]), np.array([3.0]), np.array([4.0]), np.array([9.0]))
    path = Path(np.array([0.0]), wide)
    path.run(0, way, speed)
    found = path.reference()
    assert found.q[-1, 0] == pytest.approx(way)
    assert 0.0 < np.abs(found.qd).max() <= min(speed, 4.0) * (1 + 1e-9)
    assert np.abs(found.qdd).max() <= 9.0 * (1 + 1e-9)


def test_limits_shrink() -> None:
    inside = Limits.within(LIMITS, JOINTS, 0.1)
    np.testing.assert_allclose(inside.width, 0.8 * LIMITS.width)
    np.testing.assert_allclose(inside.qd_max, 0.9 * LIMITS.qd_max)
    near = LIMITS.around(LIMITS.q_low, 0.25)
    np.testing.assert_allclose([near.q_low, near.width], [LIMITS.q_low, 0.25 * LIMITS.width])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"motion": "dance"}, ["no motion 'dance'", "chirp"]),
        ({"joint": "d"}, ["no joint d", "a, b, c"]),
        ({"duration": 0.1}, ["0.1 s", "5"]),
        ({"start": [0.0, 0.0]}, ["start", "3 finite values"]),
        ({"start": [0.0, 0.0, 0.9]}, ["start", "c at 0.9", "0.2 to 0.7"]),
        ({"pose": [0.0, np.nan, 0.5]}, ["pose", "finite"]),
    ],
)
def test_mistakes(change: dict[str, object], words: list[str]) -> None:
    arguments: dict[str, object] = {"motion": "chirp", **change}
    motion = str(arguments.pop("motion"))
    with pytest.raises(ModelError) as error:
        excite(motion, JOINTS, LIMITS, **arguments)  # type: ignore[arg-type]
    assert all(word in str(error.value) for word in words), error.value


def test_a_joint_without_a_range() -> None:
    narrow = Limits(LIMITS.q_low, LIMITS.q_high.copy(), LIMITS.qd_max, LIMITS.qdd_max)
    narrow.q_high[2] = narrow.q_low[2]
    with pytest.raises(ModelError, match="c has no room"):
        excite("speeds", JOINTS, narrow, joint="c")
    found = excite("exciting", JOINTS, narrow)
    assert not np.ptp(found.q[:, 2])
    with pytest.raises(ModelError, match=r"b: limits of 1\.5 to -1\.5"):
        Limits.within(Limits(LIMITS.q_high, LIMITS.q_low, LIMITS.qd_max, LIMITS.qdd_max), "bca")
