"""The pages of compare, diagnose and history: verdict first, true to the record, offline."""

import re
from collections.abc import Callable
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagnosis_examples import (
    JOINTS,
    changed,
    consequence,
    diagnosis,
    doubt,
    finding,
    run,
    taken_up,
)
from page_examples import SCRIPT, compared, diagnosed, investigated, lineage, motion
from test_report_html import texts

from lagrangian_ff.diagnosis import Comparison, DiagnosisRun
from lagrangian_ff.diagnosis.compare import Interval
from lagrangian_ff.diagnosis.excite import Between, Suspect
from lagrangian_ff.diagnosis.where import COORDINATES, Bins, Compared, ResidualSeries
from lagrangian_ff.identification import Score
from lagrangian_ff.identification.history import ErrorChange
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.investigation import Ended, PassedOver
from lagrangian_ff.report import (
    Section,
    compare_page,
    diagnose_page,
    history_page,
    investigation_page,
    write_page,
)
from lagrangian_ff.report import pages as written_pages
from lagrangian_ff.report.plot import Plot, embed, line

PAGES: dict[str, tuple[Callable[..., Path], Callable[[], Any]]] = {
    "compare": (compare_page, compared),
    "diagnose": (diagnose_page, diagnosed),
    "history": (history_page, lineage),
    "investigate": (investigation_page, investigated),
}
LIBRARY = re.compile(r'<script type="text/plain" id="library">.*?</script>')


def written(path: Path, name: str, result: Any = None) -> str:
    """The text of a page without plotly.js and the styles."""
    write, example = PAGES[name]
    text = write(path / "page.html", example() if result is None else result).read_text("utf-8")
    assert len(LIBRARY.findall(text)) == 1
    return re.sub(r"<style>.*?</style>", "", LIBRARY.sub("", text), flags=re.DOTALL)


def heading(path: Path, name: str, result: Any) -> str:
    """The title of a page."""
    found = re.search(r"<h1>(.*?)</h1>", PAGES[name][0](path / "page.html", result).read_text())
    assert found is not None
    return found[1]


@pytest.mark.parametrize("name", PAGES)
def test_a_page_needs_nothing_from_elsewhere(name: str, tmp_path: Path) -> None:
    page = written(tmp_path, name)
    assert not re.search(r"\bsrc=|\bhref=|<link|@import|url\(|https?://", page)
    assert list(tmp_path.iterdir()) == [tmp_path / "page.html"]


@pytest.mark.parametrize("name", PAGES)
def test_a_page_is_well_formed_and_its_texts_are_escaped(name: str, tmp_path: Path) -> None:
    page = written(tmp_path, name)
    shown = texts(page.replace("<!DOCTYPE html>", ""))
    assert shown
    assert SCRIPT not in re.sub(r'<script type="text/plain">.*?</script>', "", page)


@pytest.mark.parametrize("name", PAGES)
def test_every_figure_has_its_data_beside_it(name: str, tmp_path: Path) -> None:
    page = written(tmp_path, name)
    places = re.findall(r'<div class="plot"[^>]*></div><script type="text/plain">', page)
    assert len(places) == page.count('class="plot"') > 0


def test_compare_says_the_worst_region_first(tmp_path: Path) -> None:
    page = written(tmp_path, "compare")
    assert "elbow fails below 0.10 rad/s: 41 % of its error in 6.0 % of the time</h1>" in page
    titles = re.findall(r"<h2>(.*?)</h2>", page)
    assert titles[:2] == ["How far is the model off?", "Where it fails"]
    assert titles[-1] == "What to do next"
    assert "lagrangian_ff diagnose" in page


def test_error_that_is_spread_evenly_is_not_blamed_on_a_region(tmp_path: Path) -> None:
    found = compared()
    spread = replace(found, where=replace(found.where, regions=()))
    evenly = "The error is spread evenly over the motion"
    assert heading(tmp_path, "compare", spread) == evenly
    series, part = found.where.series, slice(20)
    brief = replace(series, motion=series.motion.take(part), residual=series.residual[part])
    short = replace(spread, where=replace(spread.where, series=brief))
    assert "too short" in heading(tmp_path, "compare", short)


def test_diagnose_goes_from_the_verdict_to_what_to_record_next(tmp_path: Path) -> None:
    page = written(tmp_path, "diagnose")
    expected = [
        "First: the measurement", "What is missing", "What touched the arm", "Where it fails",
        "The evidence",
        "Against the other candidates", "The error falls", "What to record next",
    ]  # fmt: skip
    assert re.findall(r"<h2>(.*?)</h2>", page)[: len(expected)] == expected
    assert "error 40 % lower on held-back data" in page
    assert "Could also be counterbalance, offset" in page
    assert "something 19 % the size of its torque follows position" in page
    assert "nothing is missing in 95 % of the cases" in page
    assert "model.npz diagnosed on a bag" in page


def test_an_effect_that_raises_the_error_is_not_shown_as_a_fall(tmp_path: Path) -> None:
    worse = finding("spring", doubt=doubt(), consequence=consequence(1.5, 1.8))
    page = written(tmp_path, "diagnose", run(diagnosis(findings=(worse,))))
    assert "error 20 % higher on held-back data" in page


def test_of_an_effect_of_two_joints_the_page_says_whose_error_falls(tmp_path: Path) -> None:
    both = finding("coupled", joints=("elbow", "shoulder"))
    page = written(tmp_path, "diagnose", run(diagnosis(findings=(both,))))
    assert "error of elbow 40 % lower on held-back data" in page


def test_an_investigation_is_told_turn_by_turn(tmp_path: Path) -> None:
    page = written(tmp_path, "investigate")
    assert re.search(
        r"<h1>Found stribeck on elbow: the unseen error of elbow falls, [\d.]+ → ", page
    )
    assert "2 questions to 2 joints, 40 s" in page
    expected = ["Question by question", "The error falls", "The evidence", "What is left"]
    assert re.findall(r"<h2>(.*?)</h2>", page) == expected
    for words in ("What does the arm do?", "Is there stribeck on elbow?"):
        assert words in page
    first = investigated().turns[0]
    for findings, title in (
        ((), "Nothing is missing that these motions can show"),
        ((finding(doubt=doubt()),), "Something may be missing; these motions confirm nothing"),
    ):
        turn = replace(first, diagnosis=diagnosis(findings=findings))
        story = replace(investigated(), turns=(turn,))
        assert heading(tmp_path, "investigate", story) == title
        page = written(tmp_path, "investigate", story)
        assert "The error falls" not in page
        assert "without what was found" not in page
    assert "Stribeck on elbow is no more than suggested" in page
    between = Between(Suspect("stribeck", "elbow"), Suspect("ripple", "elbow"))
    left = replace(story, passed_over=(PassedOver(between, 1.73),))
    assert "Is it stribeck or ripple on elbow? No motion" in written(tmp_path, "investigate", left)
    bare = replace(investigated(), turns=())
    assert heading(tmp_path, "investigate", bare) == "It ended before anything was known"
    refused = replace(bare, ended=Ended.REFUSED)
    assert heading(tmp_path, "investigate", refused) == "The arm did not move"


def test_nothing_found_is_said_so(tmp_path: Path) -> None:
    page = written(tmp_path, "diagnose", run(diagnosis(), where=compared().where))
    assert "<h1>No effect of the catalogue is missing that this motion could show" in page
    assert "No effect of the catalogue earned its place" in page
    assert "The evidence" not in page


def test_unknown_values_are_dashes(tmp_path: Path) -> None:
    bare = run(diagnosis(taken_up=taken_up(doubt=doubt())), where=compared().where)
    page = written(tmp_path, "diagnose", bare)
    table = re.search(r"<tr><td class=\"word\">payload</td>.*?</tr>", page)
    assert table is not None
    assert texts(table[0]) == ["payload", "shoulder, elbow", "suggested", "–", "–", "300", "–"]


def test_a_verdict_has_its_colour_whatever_it_is_ambiguous_with(tmp_path: Path) -> None:
    page = written(tmp_path, "diagnose")
    assert '<span class="badge good">confirmed</span>' in page
    assert '<span class="badge fair">ambiguous with counterbalance, offset</span>' in page


def test_what_changed_is_shown_with_its_size_and_rivals(tmp_path: Path) -> None:
    alike = changed("payload", joints=JOINTS, rivals=("mass of the link of elbow",))
    grew = {"F_c": Estimate(-1.25, unit="N·m")}
    unsure = changed("coulomb", parameters=grew, p_value=None, size=1.25)
    others = (alike, unsure, changed("rigid body", parameters={}))
    page = written(tmp_path, "diagnose", replace(diagnosed(), changed=others))
    begin = page.index("<h2>What changed since the identification</h2>")
    section = page[begin:].partition("</section>")[0]
    rows = [texts(row) for row in re.findall(r"<tr><td.*?</tr>", section)]
    assert rows[0] == [
        "payload", "shoulder, elbow", "m +0.500 kg", "0.400 … 0.600", "1.50", "90.0", "0.0025",
    ]  # fmt: skip
    assert rows[1] == ["coulomb", "elbow", "F_c −1.25 N·m", "–", "1.25", "90.0", "–"]
    assert rows[2][2] == "other masses: a load was attached or taken off"
    assert "on this motion mass of the link of elbow would explain as much" in section
    assert 'class="plot"' in section


def test_a_page_says_that_nothing_changed_only_if_it_was_asked(tmp_path: Path) -> None:
    assert "What changed" not in written(tmp_path, "diagnose")
    page = written(tmp_path, "diagnose", replace(diagnosed(), changed=()))
    assert "the arm is as it was" in page


def test_a_new_section_is_one_function_and_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def toy_section(run: DiagnosisRun) -> Section:
        figure = Plot([line([0.0, 1.0], [0.0, 1.0], "toy", "#000000")])
        return Section("A toy", "It has a lead.", embed(figure, f"toy of {run.model_file}"))

    monkeypatch.setattr(written_pages, "DIAGNOSE", [*written_pages.DIAGNOSE, toy_section])
    page = written(tmp_path, "diagnose")
    assert re.findall(r"<h2>(.*?)</h2>", page)[-1] == "A toy"
    assert "It has a lead." in page
    assert 'aria-label="toy of model.npz"' in page


def test_history_says_how_much_of_the_error_is_gone(tmp_path: Path) -> None:
    assert heading(tmp_path, "history", lineage()) == (
        "With torque ripple on joint_2, 50 % of the error is gone: 2.00 → 1.00 N·m on held-back "
        "data"
    )
    page = written(tmp_path, "history")
    assert "2026-01-02 03:04" in page
    assert "A wave of 20 to a turn." in page


def test_a_model_without_additions_has_a_history_too(tmp_path: Path) -> None:
    history = lineage()
    path = history_page(tmp_path / "page.html", replace(history, steps=history.steps[:1]))
    assert "Nothing was added" in path.read_text("utf-8")


def test_the_heading_is_the_first_sentence(tmp_path: Path) -> None:
    assert unescape(heading(tmp_path, "diagnose", diagnosed())) == (
        "Missing and confirmed: stribeck on elbow: the joint's error falls from 1.5 to 0.9 N·m on "
        "motion not used to find it"
    )
    assert "<p>On elbow one of these is missing" in written(tmp_path, "diagnose")


def test_a_page_without_interactive_figures_holds_no_script(tmp_path: Path) -> None:
    page = write_page(tmp_path / "page.html", "title", [Section("a", "", "<p>b</p>")])
    assert "<script" not in page.read_text("utf-8")


def long_motion() -> Compared:
    """A comparison over 10 minutes of 6 joints that moved all the time."""
    rng = np.random.default_rng(0)
    joints = tuple(f"joint_{k + 1}" for k in range(6))
    measured = motion(joints, 0.4, 1500)
    found = Comparison(
        replace(measured, tau=100.0 * rng.normal(size=(1500, 6))),
        100.0 * rng.normal(size=(1500, 6)),
        Score(joints, np.ones(6), np.full(6, 0.1)),
        0.125,
        Interval(joints, np.arange(1500), rng.uniform(1.0, 2.0, (1500, 6)), np.full(6, 0.9), 600),
    )
    low, high, mean, rms = (np.sort(rng.normal(size=40)) for _ in range(4))
    coordinates = [
        replace(COORDINATES["velocity"], name=f"quantity {k}", label=f"the quantity number {k}")
        for k in range(10)
    ]
    example = compared().where
    where = replace(
        example,
        comparison=found,
        series=ResidualSeries(found.motion, found.residual, found.motion.tau, np.zeros(1500)),
        bins=tuple(
            Bins(coordinate, joint, low, high, mean, mean - 0.1, mean + 0.1, rms, rms, rms, 0.3)
            for joint in joints
            for coordinate in coordinates
        ),
    )
    return Compared("model.npz", ("a bag",), where)


def test_a_page_of_a_long_motion_is_small(tmp_path: Path) -> None:
    path = compare_page(tmp_path / "compare.html", long_motion())
    assert path.stat().st_size < 2e6


@pytest.mark.parametrize("name", PAGES)
def test_words_and_tables_come_before_any_script(name: str, tmp_path: Path) -> None:
    write, example = PAGES[name]
    page = write(tmp_path / "page.html", example()).read_text("utf-8")
    head, _, rest = page.partition("</main>")
    assert not re.search(r"<script>|<script src|id=[^\n]library", head)
    assert rest.count("<script") == 2


def test_the_fall_of_one_effect_is_that_of_its_joint(tmp_path: Path) -> None:
    history = lineage()
    first, second = history.steps
    joints = {**second.joints, "joint_2": ErrorChange(1.06, 0.629)}
    history = replace(history, steps=(first, replace(second, joints=joints)))
    assert heading(tmp_path, "history", history).startswith(
        "With torque ripple on joint_2, 41 % of the error of joint_2 is gone: 1.06 → 0.629 N·m"
    )
