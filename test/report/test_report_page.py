"""The page: one file that needs nothing else, with everything in it."""

import re
from pathlib import Path

import pytest
from report_examples import comparison, effects, runs
from test_report_html import texts

from lagrangian_ff.report import Section, html, write_page
from lagrangian_ff.report.sections.effects import effects_section
from lagrangian_ff.report.sections.torque import torque_figure, torque_section
from lagrangian_ff.report.sections.tracking import tracking_section, tracking_time_figure
from lagrangian_ff.report.style import png


def sections() -> list[Section]:
    """A page as the demo has it."""
    found = comparison()
    torque = png(torque_figure(found.motion, found.predicted))
    return [
        Section("Verdict", "", html.cards([html.Card("3 ×", "better", good=True)])),
        tracking_section(runs(), png(tracking_time_figure(runs())), "Tracking", "how far off"),
        torque_section(found, torque, "Torque", "how well predicted"),
        effects_section(effects()),
    ]


@pytest.fixture
def page(tmp_path: Path) -> str:
    path = write_page(
        tmp_path / "page.html", "1 < 2", sections(), summary="a summary", footer="the end"
    )
    return path.read_text(encoding="utf-8")


def test_the_page_needs_nothing_from_elsewhere(page: str) -> None:
    sources = re.findall(r'(?:src|href)="([^"]*)"', page)
    assert sources
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    rest = re.sub(r'base64,[^"]*', "", page)
    assert not re.search(r"://|//[a-z]|<script|<link|@import|url\(", rest, re.IGNORECASE)


def test_the_page_holds_every_section_in_order(page: str) -> None:
    places = [page.index(f"<h2>{section.title}</h2>") for section in sections()]
    assert places == sorted(places)
    for section in sections():
        assert section.body in page


def test_the_page_is_well_formed_and_escaped(page: str) -> None:
    shown = texts(re.sub(r"<style>.*?</style>", "", page, flags=re.DOTALL))
    assert "1 < 2" in shown
    assert {"a summary", "the end"} <= set(shown)


def test_the_styles_are_those_of_the_package(page: str) -> None:
    assert "--accent" in page


def test_an_old_page_is_replaced_and_nothing_else_is_left(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text("old", encoding="utf-8")
    write_page(path, "new", [])
    assert "old" not in path.read_text(encoding="utf-8")
    assert list(tmp_path.iterdir()) == [path]
