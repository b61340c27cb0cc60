"""The pages of compare, diagnose and history: verdict first, true to the record, offline."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from page_examples import SCRIPT, compared, diagnosed, finding, lineage
from test_report_html import texts

from lagrangian_ff.report import Section, compare_page, diagnose_page, history_page, write_page
from lagrangian_ff.report.pages.compare import headline
from lagrangian_ff.report.pages.diagnose import split
from lagrangian_ff.report.pages.history import headline as history_headline

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


def test_error_that_is_spread_evenly_is_not_blamed_on_a_region() -> None:
    record = compared() | {"regions": []}
    assert headline(record) == "The error is spread evenly over the motion"
    short = record | {"too_short": True}
    assert "too short" in headline(short)


def test_diagnose_goes_from_the_verdict_to_what_to_record_next(tmp_path: Path) -> None:
    page = written(tmp_path, "diagnose")
    assert "<h1>elbow misses Stribeck friction of 1.2 N·m (confirmed)</h1>" in page
    expected = [
        "First: the measurement", "What is missing", "Where it fails", "The evidence",
        "Against the other candidates", "The error falls", "What to record next",
    ]  # fmt: skip
    assert re.findall(r"<h2>(.*?)</h2>", page)[: len(expected)] == expected
    assert "error 40 % lower on held-back data" in page
    assert "Could also be gear mesh on elbow, spring" in page
    assert "something 19 % the size of its torque follows position" in page


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


def test_history_tells_how_much_of_the_error_is_gone(tmp_path: Path) -> None:
    assert history_headline(lineage()) == (
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


def test_the_heading_is_the_first_sentence() -> None:
    assert split("It fell from 5.2 to 3.4 N·m. More may come.") == (
        "It fell from 5.2 to 3.4 N·m", "More may come.",
    )  # fmt: skip


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


def test_one_effect_is_told_by_its_own_joint() -> None:
    record = lineage()
    record["steps"][-1]["joints"]["joint_2"] = {"before": 1.06, "after": 0.629}
    assert history_headline(record).startswith(
        "With torque ripple on joint_2, 41 % of the error of joint_2 is gone: 1.06 → 0.629 N·m"
    )
