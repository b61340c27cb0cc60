"""The findings of errors over speed, on numbers made up so that they are known."""

from itertools import product
from typing import Any

import pytest

from lagrangian_ff.studies.arm import Errors, ends
from lagrangian_ff.studies.speeds import loaded_findings, prediction_findings
from lagrangian_ff.studies.tracking import tracking_findings


def errors(**of: list[float]) -> Errors:
    """Return errors at the speeds 1, 2, ... by name, where `_` stands for +."""
    return Errors(
        {name.replace("_", "+"): dict(enumerate(values, start=1)) for name, values in of.items()},
        {speed: 0.4 * speed for speed in range(1, 11)},
    )


def test_lines_are_collected_by_name_and_rising_speed() -> None:
    lines: list[dict[str, Any]] = [
        {"case": f"{speed}{model}", "model": model, "speed": speed, "velocity": 0.5 * speed}
        | {"rmse": float(speed * len(model))}
        for model, speed in product(("a", "bb"), (3, 1, 2))
    ]
    found = Errors.collected([*lines[1:], {"case": "x", "failed": "broke"}])
    assert found.of == {"a": {1: 1.0, 2: 2.0}, "bb": {1: 2.0, 2: 4.0, 3: 6.0}}
    assert found.common("a", "bb") == [1, 2]
    assert found.common("a", "c") == []
    assert found.record()["bb"] == {
        "speed": [1, 2, 3],
        "velocity": [0.5, 1.0, 1.5],
        "rmse": [2.0, 4.0, 6.0],
    }


def test_every_trajectory_counts_the_same() -> None:
    two = errors(a=[1.0, 100.0], b=[2.0, 50.0])
    assert two.mean("a", [1, 2]) == pytest.approx(10.0)
    assert two.ratio("a", "b", [1, 2]) == pytest.approx(1.0)
    assert two.below("a", "b", [1, 2]) == 1


def test_the_ends_are_thirds() -> None:
    assert ends([1, 2]) == ([1], [2])
    assert ends(list(range(1, 11))) == ([1, 2, 3], [8, 9, 10])


@pytest.mark.parametrize(
    ("motor", "holds"),
    [([1.0, 2.0, 4.0], True), ([1.0, 1.0, 1.1], False), ([4.0, 2.0, 2.0], False)],
)
def test_who_deteriorates_grows_faster_than_the_reference(motor: list[float], holds: bool) -> None:
    found = prediction_findings(errors(motor_fri=motor, vrbfs_fri=[0.5, 0.6, 0.7]))
    finding = found["motor_deteriorates"]
    assert finding.holds is holds
    assert finding.figures["rise"]["motor+fri"] == pytest.approx(motor[2] / motor[0])
    assert finding.figures["rise"]["vrbfs+fri"] == pytest.approx(1.4)


def test_the_best_of_the_papers_models_is_named() -> None:
    of = {"motor_fri": [3.0, 4.0], "srbfs_fri": [1.0, 3.0], "pol_fri": [2.0, 2.0]}
    best = prediction_findings(errors(**of, auto_fri=[0.1, 0.1]))["lagrangian_best"]
    assert best.holds is True
    assert best.figures["first"] == 1
    assert set(best.figures["mean"]) == {"motor+fri", "srbfs+fri", "pol+fri"}
    worse = prediction_findings(errors(**{**of, "pol_fri": [1.5, 1.5]}))["lagrangian_best"]
    assert worse.holds is False


def test_friction_is_needed_where_it_lowers_the_error_at_low_speed() -> None:
    of = {"rbf": [4.0, 1.0, 1.0], "rbf_fri": [1.0, 2.0, 2.0], "pol": [3.0, 3.0, 3.0]}
    needed = prediction_findings(errors(**of))["friction_needed"]
    assert (needed.holds, needed.figures["ratio"]) == (True, {"rbf": pytest.approx(0.25)})
    with_pol = prediction_findings(errors(**of, pol_fri=[3.1, 1.0, 1.0]))["friction_needed"]
    assert with_pol.holds is False


def test_ours_are_compared_with_the_papers_best() -> None:
    found = prediction_findings(
        errors(vrbfs_fri=[2.0, 2.0], auto_fri=[1.0, 1.0], energy_fri=[1.0, 8.0])
    )
    assert found["auto+fri_better"].holds is True
    assert found["auto+fri_better"].figures["ratio"] == pytest.approx(0.5)
    assert found["energy+fri_better"].holds is False
    assert found["energy+fri_better"].figures["below"] == 1


def test_a_gap_is_wider_and_grows_faster_with_masses_or_not() -> None:
    light = errors(motor_fri=[2.0, 3.0, 4.0], vrbfs_fri=[1.0, 1.0, 1.0])
    heavy = errors(motor_fri=[2.0, 5.0, 8.0], vrbfs_fri=[1.0, 1.0, 2.0])
    found = loaded_findings(heavy, light)
    assert [each.holds for each in found.values()] == [True, True]
    assert found["gap_wider"].figures["gap"] == pytest.approx({"loaded": 6.0, "unloaded": 3.0})
    assert found["motor_deteriorates_faster"].figures["growth"] == pytest.approx(
        {"loaded": 6.0, "unloaded": 2.0}
    )
    assert [each.holds for each in loaded_findings(light, heavy).values()] == [False, False]


def test_groups_of_feedforward_must_not_mix() -> None:
    of = {"none": [9.0, 9.0], "true": [0.1, 0.1], "vrbfs": [5.0, 4.0], "vrbfs_fri": [1.0, 1.0]}
    found = tracking_findings(errors(**of, auto_fri=[0.5, 2.0]))
    assert found["three_groups"].holds is True
    assert found["three_groups"].figures["apart"] == [2, 2]
    assert found["ours_nearest"].figures["below"] == 1
    mixed = tracking_findings(errors(**of, motor_fri=[3.0, 7.0]))["three_groups"]
    assert (mixed.holds, mixed.figures["apart"]) == (False, [2, 1])


def test_of_nothing_nothing_is_said() -> None:
    nothing = errors()
    assert prediction_findings(nothing) == {}
    assert tracking_findings(nothing) == {}
    assert loaded_findings(nothing, nothing) == {}
