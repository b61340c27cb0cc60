"""The loop that closes itself, in a real browser: on the simulated arm, and where there is none."""

import re
import signal
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from browsing import LONG, chromium, idle, needs_chromium, opened, shown, violations
from workbench_examples import Served, moved, serving

pytest.importorskip("pybullet")
playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
pytestmark = needs_chromium
serve = pytest.fixture(serving)
browser = pytest.fixture(scope="module")(chromium)
page = pytest.fixture(opened)


@pytest.fixture(scope="module")
def tried(
    browser: Any, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Callable[..., Served]]:
    """Return what opens a session with the simulated arm; it has a recording already."""
    folder = tmp_path_factory.mktemp("tried")
    source = moved(folder / "motion.npz", 0)
    for serve in serving():
        first = serve(folder / "session", source)
        for page in opened(browser):
            shown(page, first)
            page.goto(first.address + "#investigate")
            text = page.locator("#view").inner_text()
            assert f"lagrangian_ff workbench --live --session {first.session}" in text
            assert page.get_by_role("button", name="Investigate").count() == 1  # the step alone
        assert first.stop() == 0
        yield partial(serve, folder / "session", "--try")


def begun(page: Any, served: Served, minutes: float) -> None:
    """Let the simulated arm be investigated."""
    page.goto(served.address + "#investigate")
    page.get_by_label("Minutes of motion").fill(str(minutes))
    page.locator("#view").get_by_role("button", name="Investigate").click()
    page.get_by_role("heading", name="Under way").wait_for(timeout=LONG)


def test_one_click_and_the_story_is_told(
    tried: Callable[..., Served], page: Any, browser: Any
) -> None:
    served = tried()
    page.goto(served.address + "#investigate")
    page.get_by_label("Minutes of motion").fill("0.05")
    page.locator("#view").get_by_role("button", name="Investigate").click()
    page.get_by_text("0.05 minutes: expected 0.15 to 60").wait_for()
    begun(page, served, 0.15)
    page.locator(".asked").get_by_text("What does the arm do?").wait_for(timeout=LONG)
    page.reload()
    page.locator(".asked").get_by_text("What does the arm do?").wait_for(timeout=LONG)
    page.get_by_role("heading", name="In the end").wait_for(timeout=LONG)
    idle(page)
    words = page.locator("#view").inner_text()
    assert "the time for motion is used" in words
    assert "Its 1 motion is a card" in words
    assert page.locator("section.finding svg path").count() == 6, "all joints have moved"
    found = "Confirmed by then" in words
    assert page.locator("svg .beside").count() == found, "the model without what was found"
    assert page.get_by_role("heading", name="the error falls").count() == found
    with page.expect_download() as download:
        page.get_by_role("link", name="Page of the story").click()
    assert "Question by question" in Path(download.value.path()).read_text()
    for scheme in ("light", "dark"):
        for other in opened(browser, bypass_csp=True, color_scheme=scheme):
            other.goto(served.address + "#investigate")
            other.get_by_role("heading", name="In the end").wait_for()
            assert not violations(other), scheme
    page.get_by_role("button", name="Go to its steps").click()
    tree = page.locator("section", has_text="All models")
    assert re.search(r"investigation 1 – [\d.]+ N·m", tree.inner_text())
    page.goto(served.address + "#data")
    card = page.locator("article", has_text="investigation 1, motion 1")
    card.get_by_text("6 joints").wait_for()
    assert card.get_by_label("use of").input_value() == "learn"
    page.goto(served.address + "#take")
    commands = page.locator("pre").last.inner_text()
    assert "motion_1 --train 0.6 --output model.npz" in commands
    assert "learned from 0.6 of every 8 s" in commands
    assert served.stop() == 0


def test_a_stop_keeps_what_is_known_and_a_killed_server_its_motions(
    tried: Callable[..., Served], page: Any
) -> None:
    served = tried()
    begun(page, served, 4.0)
    page.get_by_role("button", name="Stop the arm").click()
    page.get_by_text("stopped by the user").first.wait_for(timeout=LONG)
    idle(page)
    begun(page, served, 0.5)
    page.goto(served.address + "#data")
    page.locator("article", has_text=re.compile("investigation [23], motion 1")).wait_for(
        timeout=LONG
    )
    served.stop(signal.SIGKILL)
    served = tried()
    page.goto(served.address + "#investigate")
    page.get_by_text("the workbench ended before it did").first.wait_for()
    page.goto(served.address + "#data")
    last = page.locator("article", has_text=", motion 1").last
    last.get_by_text("6 joints").wait_for(timeout=LONG)
    assert served.stop() == 0
