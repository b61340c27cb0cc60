"""Sections: the numbers on the page are those of the record."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from diagnosis_examples import diagnosis, fault
from diagnosis_examples import run as run_of
from page_examples import compared
from report_examples import JOINTS, comparison, effects, runs
from test_report_html import PICTURE, texts

from lagrangian_ff.diagnosis.compare import Interval
from lagrangian_ff.numbers import mrad, percent, typeset
from lagrangian_ff.report import compare_page
from lagrangian_ff.report.sections.effects import effects_section
from lagrangian_ff.report.sections.errors import errors_section
from lagrangian_ff.report.sections.limits import serious_section
from lagrangian_ff.report.sections.torque import torque_section
from lagrangian_ff.report.sections.tracking import tracking_section


def test_the_torque_section_shows_the_record() -> None:
    found = comparison()
    section = torque_section(found, PICTURE, "Torque", "lead")
    shown = texts(section.body)
    record = found.record()["joints"]
    assert isinstance(record, dict)
    for joint, errors in record.items():
        row = shown.index(joint)
        assert shown[row + 2] == typeset(errors["rmse"])
        assert shown[row + 4] == typeset(errors["nmse"])
    assert any(percent(found.outside) in text for text in shown)


def test_the_share_inside_the_intervals_is_said_if_it_is_known(tmp_path: Path) -> None:
    interval = Interval(JOINTS, np.arange(3), np.ones((3, 2)), np.array([0.93, 0.41]), 60)
    found = replace(comparison(), interval=interval)
    shown = texts(torque_section(found, PICTURE, "Torque", "lead").body)
    for joint, share in zip(JOINTS, ("93 %", "41 %"), strict=True):
        assert shown[shown.index(joint) + 5] == share
    without = compared()
    sure = replace(without.where.comparison, interval=interval)
    record = replace(without, where=replace(without.where, comparison=sure))
    shown = texts(errors_section(record.where).body)
    for joint, share in zip(JOINTS, ("93 %", "41 %"), strict=True):
        assert shown[len(shown) - shown[::-1].index(joint) + 3] == share
    page = compare_page(tmp_path / "page.html", record).read_text("utf-8")
    assert "only 41% of elbow lie inside" in page
    page = compare_page(tmp_path / "page.html", without).read_text("utf-8")
    assert "lie inside" not in page


def test_the_tracking_section_shows_the_record() -> None:
    shown = texts(tracking_section(runs(), PICTURE, "Tracking", "lead").body)
    for run in runs():
        record = run.record()
        assert run.label in shown
        assert isinstance(record["joints"], dict)
        for joint, errors in record["joints"].items():
            place = shown.index(run.label) - shown.index("RMS error [mrad]")
            assert shown[shown.index(joint) + place] == mrad(errors["rms"])


def test_the_effects_section_shows_values_intervals_and_truth() -> None:
    section = effects_section(effects(), {("coulomb", "F_c"): [1.4, 2.6]}, remark="a remark")
    shown = texts(section.body)
    assert "τ = F_c tanh(qd / v0)" in shown
    assert "F_c [N·m]" in shown
    assert "v0 [rad/s]" in shown
    assert shown[-1] == "a remark"
    for n, joint in enumerate(JOINTS):
        row = shown.index(joint)
        found = effects()[n].parameters["F_c"]
        assert shown[row + 1 : row + 5] == [
            typeset(found.value),
            f"{typeset(found.low)} … {typeset(found.high)}",
            typeset((1.4, 2.6)[n]),
            typeset(0.02),
        ]


def test_without_truth_there_is_no_column_for_it() -> None:
    assert "true value" not in effects_section(effects()).body


def test_a_model_without_effects_says_so() -> None:
    assert "no effects" in effects_section([]).body


@pytest.mark.parametrize("name", ["none", "some"])
def test_the_record_of_a_run_is_in_rad(name: str) -> None:
    run = next(run for run in runs() if run.label == name)
    record = run.record()
    assert record["unit"] == "rad"
    assert record["rms"] == pytest.approx(((run.error**2).mean()) ** 0.5)
    assert record["largest"] == pytest.approx(abs(run.error).max())


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("the effort of elbow rests at 10 N·m", "The effort of elbow rests at 10 N·m. Go slower."),
        ("it is noisy", "elbow: It is noisy. Go slower."),
    ],
)
def test_a_fault_names_its_joint_once(text: str, told: str) -> None:
    check = fault(finding=text, advice="go slower")
    section = serious_section(run_of(diagnosis(), checks=(check,)))
    assert section is not None
    assert texts(section.body) == [told]
