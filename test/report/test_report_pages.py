"""The pages of compare, diagnose and history: verdict first, true to the record, offline."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from page_examples import SCRIPT, changed, compared, diagnosed, finding, lineage
from test_report_html import texts

from lagrangian_ff.report import Section, compare_page, diagnose_page, history_page, write_page
from lagrangian_ff.report import pages as written_pages
from lagrangian_ff.report.plot import Plot, embed, line

PAGES: dict[str, tuple[Callable[..., Path], Callable[[], dict[str, Any]]]] = {
    "compare": (compare_page, compared),
    "diagnose": (diagnose_page, diagnosed),
    "history": (history_page, lineage),
}
LIBRARY = re.compile(r'<script type="text/plain" id="library">.*?</script>')


def written(path: Path, name: str, record: dict[str, Any] | None = None) -> str:
    """The text of a page without plotly.js and the styles."""
    write, example = PAGES[name]
    text = write(path / "page.html", example() if record is None else record).read_text("utf-8")
    assert len(LIBRARY.findall(text)) == 1
    return re.sub(r"<style>.*?</style>", "", LIBRARY.sub("", text), flags=re.DOTALL)


def heading(path: Path, name: str, record: dict[str, Any]) -> str:
    """The title of a page."""
    found = re.search(r"<h1>(.*?)</h1>", PAGES[name][0](path / "page.html", record).read_text())
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
    record = compared() | {"regions": []}
    evenly = "The error is spread evenly over the motion"
    assert heading(tmp_path, "compare", record) == evenly
    short = record | {"too_short": True, "words": ["the recording is too short"]}
    assert "too short" in heading(tmp_path, "compare", short)


def test_diagnose_goes_from_the_verdict_to_what_to_record_next(tmp_path: Path) -> None:
    page = written(tmp_path, "diagnose")
    assert "<h1>elbow misses Stribeck friction of 1.2 N·m (confirmed)</h1>" in page
    expected = [
        "First: the measurement", "What is missing", "Where it fails", "The evidence",
        "Against the other candidates", "The error falls", "What to record next",
    ]  # fmt: skip
    assert re.findall(r"<h2>(.*?)</h2>", page)[: len(expected)] == expected
    assert "error 40 % lower on held-back data" in page
    assert "Could also be gear mesh, spring" in page
    assert "something 19 % the size of its torque follows position" in page
    assert "nothing is missing in 95 % of the cases" in page


def test_an_effect_that_raises_the_error_is_not_shown_as_a_fall(tmp_path: Path) -> None:
    record = diagnosed() | {"findings": [finding("spring", "suggested", error_after=1.8)]}
    assert "error 20 % higher on held-back data" in written(tmp_path, "diagnose", record)


def test_nothing_found_is_said_so(tmp_path: Path) -> None:
    record = diagnosed() | {
        "verdict": "Nothing is missing.", "findings": [], "ranking": [], "steps": [],
        "unexplained": [], "not_observable": [], "preflight": [],
    }  # fmt: skip
    page = written(tmp_path, "diagnose", record)
    assert "<h1>Nothing is missing</h1>" in page
    assert "No effect of the catalogue" in page
    assert "The evidence" not in page


def test_unknown_values_are_dashes(tmp_path: Path) -> None:
    bare = {"effect": "spring", "joints": ["elbow"], "verdict": "suggested"}
    page = written(tmp_path, "diagnose", diagnosed() | {"findings": [bare]})
    assert "spring on elbow" in page
    table = re.search(r"<tr><td class=\"word\">spring</td>.*?</tr>", page)
    assert table is not None
    assert texts(table[0]) == ["spring", "elbow", "suggested", "–", "–", "–", "–"]


def test_a_verdict_has_its_colour_whatever_it_is_ambiguous_with(tmp_path: Path) -> None:
    page = written(tmp_path, "diagnose")
    assert '<span class="badge good">confirmed</span>' in page
    assert '<span class="badge fair">ambiguous with gear mesh, spring</span>' in page


def test_what_changed_is_shown_with_its_size_and_rivals(tmp_path: Path) -> None:
    alike = changed("payload", joints=["shoulder", "elbow"], rivals=["mass of the link of elbow"])
    unsure = changed(
        "coulomb", change={"F_c": {"value": -1.25, "unit": "N·m"}}, p_value=None, size=1.25
    )
    record = diagnosed() | {"changed": [alike, unsure, changed("rigid body", change={})]}
    page = written(tmp_path, "diagnose", record)
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
    page = written(tmp_path, "diagnose", diagnosed() | {"changed": []})
    assert "the arm is as it was" in page


def test_a_new_section_is_one_function_and_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def toy_section(record: Mapping[str, Any]) -> Section:
        figure = Plot([line([0.0, 1.0], [0.0, 1.0], "toy", "#000000")])
        return Section("A toy", "It has a lead.", embed(figure, f"toy of {record['model']}"))

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
    record = lineage()
    record["steps"] = record["steps"][:1]
    path = history_page(tmp_path / "page.html", record)
    assert "Nothing was added" in path.read_text("utf-8")


def test_the_heading_is_the_first_sentence(tmp_path: Path) -> None:
    record = diagnosed() | {"verdict": "It fell from 5.2 to 3.4 N·m. More may come."}
    assert heading(tmp_path, "diagnose", record) == "It fell from 5.2 to 3.4 N·m"
    assert "<p>More may come.</p></header>" in written(tmp_path, "diagnose", record)


def test_a_page_without_interactive_figures_holds_no_script(tmp_path: Path) -> None:
    page = write_page(tmp_path / "page.html", "title", [Section("a", "", "<p>b</p>")])
    assert "<script" not in page.read_text("utf-8")


def long_motion() -> dict[str, Any]:
    """A record of compare of 10 minutes of 6 joints that moved all the time."""
    rng = np.random.default_rng(0)
    record, joints = compared(), [f"joint_{k + 1}" for k in range(6)]
    few = compared()["bins"][0]
    many = {
        name: np.sort(rng.normal(size=40)).tolist() if isinstance(value, list) else value
        for name, value in few.items()
    }
    coordinates = [(f"quantity {k}", f"the quantity number {k}") for k in range(10)]
    torques = {
        "measured": (100.0 * rng.normal(size=1500)).tolist(),
        "predicted": (100.0 * rng.normal(size=1500)).tolist(),
        "reach": rng.uniform(1.0, 2.0, 1500).tolist(),
    }
    record["joints"] = {joint: {"rmse": 1.0, "nmse": 0.1} for joint in joints}
    record["bins"] = [
        {**many, "joint": joint, "coordinate": name, "label": label}
        for joint in joints
        for name, label in coordinates
    ]
    record["blocks"] = [
        {"begin": 3.0 * k, "end": 3.0 * k + 3.0, "joints": dict.fromkeys(joints, 1.0)}
        for k in range(200)
    ]
    record["series"] = {
        "time": np.arange(0.0, 600.0, 0.4).tolist(),
        "segment": [0] * 1500,
        "joints": dict.fromkeys(joints, torques),
    }
    return record


def test_a_page_of_a_long_motion_is_small(tmp_path: Path) -> None:
    path = compare_page(tmp_path / "compare.html", long_motion())
    assert path.stat().st_size < 2e6


@pytest.mark.parametrize("name", PAGES)
def test_words_and_tables_come_before_any_script(name: str, tmp_path: Path) -> None:
    write, example = PAGES[name]
    page = write(tmp_path / "page.html", example()).read_text("utf-8")
    head, _, rest = page.partition("</main>")
    assert not re.search(r"<script>|<script src|id=.library", head)
    assert rest.count("<script") == 2


def test_the_fall_of_one_effect_is_that_of_its_joint(tmp_path: Path) -> None:
    record = lineage()
    record["steps"][-1]["joints"]["joint_2"] = {"before": 1.06, "after": 0.629}
    assert heading(tmp_path, "history", record).startswith(
        "With torque ripple on joint_2, 41 % of the error of joint_2 is gone: 1.06 → 0.629 N·m"
    )
