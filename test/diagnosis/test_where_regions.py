"""The regions that hold most of the error: planted ones are found, spread error names none."""

import numpy as np
import pytest
from where_examples import motion, noise, series

from lagrangian_ff.diagnosis.where import COORDINATES, PAIRS, Region, ResidualSeries, find_regions
from lagrangian_ff.effects.reversals import direction, since_reversal
from lagrangian_ff.recording.motion import Motion

QUIET = 0.1


def planted(moved: Motion, place: np.ndarray, seed: int = 0) -> ResidualSeries:
    """Noise everywhere, and five times as much of it in one place."""
    r = noise(len(moved), seed)
    return series(moved, QUIET * r * np.where(place, 5.0, 1.0))


def inside(looked: ResidualSeries, region: Region) -> np.ndarray:
    """Where all conditions of a region hold."""
    return np.logical_and.reduce([one.holds(looked, 0) for one in region.conditions])


@pytest.mark.parametrize("seed", range(3))
def test_error_at_low_speed_is_found(seed: int) -> None:
    moved = motion(seed)
    slow = np.abs(moved.qd[:, 0]) < 0.2
    region = find_regions(planted(moved, slow, seed), 0)[0]
    assert region.conditions[0].coordinate == "velocity"
    assert region.conditions[0].high == pytest.approx(0.2, abs=0.1)
    assert region.place.startswith("below 0.")


def test_error_after_a_reversal_is_found() -> None:
    moved = motion(1)
    with np.errstate(invalid="ignore"):
        after = since_reversal(moved.time, moved.qd[:, 0], moved.segment) < 0.15
    regions = find_regions(planted(moved, after), 0)
    assert any("after a reversal" in region.words for region in regions)
    assert regions[0].share_of_error > 2.0 * regions[0].share_of_time


def test_error_at_some_positions_in_one_direction_is_found_as_both() -> None:
    moved = motion(2)
    place = (moved.q[:, 0] > 0.3) & (direction(moved.qd[:, 0], moved.segment) > 0.0)
    looked = planted(moved, place)
    region = find_regions(looked, 0)[0]
    assert {one.coordinate for one in region.conditions} == {"position", "direction"}
    found = inside(looked, region)
    assert (found & place).sum() > 0.7 * (found | place).sum()


def test_error_outside_what_the_model_knows_is_found() -> None:
    moved = motion(3)
    away = moved.q[:, 0] + moved.qd[:, 0] > 1.5
    r = QUIET * noise(len(moved), 0) * np.where(away, 5.0, 1.0)
    region = find_regions(series(moved, r, away.astype(np.float64)), 0)[0]
    assert region.place == "outside the range the model was identified on"


def test_a_burst_in_time_is_found_beside_what_else_there_is() -> None:
    moved = motion(4)
    burst = (moved.time > 20.0) & (moved.time < 32.0)
    regions = find_regions(planted(moved, burst), 0)
    times = [one for region in regions for one in region.conditions if one.coordinate == "time"]
    assert len(times) == 1
    assert times[0].low == pytest.approx(20.0, abs=3.0)
    assert times[0].high == pytest.approx(32.0, abs=3.0)


def test_error_spread_evenly_names_hardly_ever_a_region() -> None:
    named = sum(
        bool(find_regions(series(moved, noise(len(moved), 100 + seed)), 0, seed))
        for seed in range(30)
        if (moved := motion(seed))
    )
    assert named <= 3


def test_what_is_said_of_a_region_is_what_it_holds() -> None:
    moved = motion(5)
    looked = planted(moved, np.abs(moved.qd[:, 0]) < 0.2)
    squared = looked.residual[:, 0] ** 2
    for region in find_regions(looked, 0):
        place = inside(looked, region)
        assert region.share_of_time == pytest.approx(place.mean())
        assert region.share_of_error == pytest.approx(squared[place].sum() / squared.sum())
        assert region.band[0] <= region.share_of_error <= region.band[1]
        assert region.rms == pytest.approx(np.sqrt(squared[place].mean()))
        assert region.share_of_error >= 1.5 * region.share_of_time


def test_the_same_data_give_the_same_words() -> None:
    moved = motion(6)
    looked = planted(moved, np.abs(moved.qd[:, 0]) < 0.2)
    assert find_regions(looked, 0, 1) == find_regions(looked, 0, 1)


def test_a_perfect_model_fails_nowhere() -> None:
    moved = motion(7)
    assert find_regions(series(moved, np.zeros(len(moved))), 0) == []


def test_pairs_are_of_coordinates_that_exist() -> None:
    assert {name for pair in PAIRS for name in pair} <= set(COORDINATES)


@pytest.mark.parametrize(
    ("name", "low", "high", "words"),
    [
        ("velocity", -0.1, 0.1, "below 0.10 rad/s"),
        ("velocity", -2.0, 0.5, "at velocities below 0.50 rad/s"),
        ("speed", 1.2, 2.0, "above 1.2 rad/s"),
        ("position", 0.25, 0.5, "at positions between 0.25 and 0.50 rad"),
        ("load", -2.0, -1.0, "under a load below −1.0 N·m"),
        ("since_reversal", 0.0, 0.2, "after a reversal, within 0.20 s"),
        ("before_reversal", 0.0, 0.2, "before a reversal, within 0.20 s"),
        ("time", 0.5, 1.5, "from 0.50 to 1.5 s"),
        ("direction", -1.0, -1.0, "moving backwards"),
    ],
)
def test_words(name: str, low: float, high: float, words: str) -> None:
    assert COORDINATES[name].words(low, high, -2.0 if low < 0.0 else 0.0, 2.0) == words
