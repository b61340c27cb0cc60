"""The loop that closes itself beside a running arm: permitted on the page, and stopped there."""

import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from browsing import LONG, chromium, idle, needs_chromium, opened, violations
from scripted_arm import TOPIC, Driver, driving, path_of
from workbench_examples import Served, serving

playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
pytestmark = needs_chromium
browser = pytest.fixture(scope="module")(chromium)
page = pytest.fixture(opened)
LIMITS = """
joint_limits:
  a: {min_position: -1.0, max_position: 1.0, max_velocity: 3.0}
  b: {min_position: -0.8, max_position: 1.2, max_velocity: 3.0}
"""


@pytest.fixture(scope="module")
def driver(ros_environment: dict[str, str]) -> Iterator[Driver]:
    with driving(0.9, moving=False) as made:
        yield made


@pytest.fixture(scope="module")
def served(driver: Driver, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """Return a workbench beside the scripted arm, without a recording."""
    for serve in serving():
        yield serve(tmp_path_factory.mktemp("live") / "session", "--live")


def asked(served: Served, what: str, **question: Any) -> tuple[int, dict[str, Any]]:
    """Return the answer to what the page could ask."""
    data = json.dumps(question).encode()
    status, body = served.asked(f"api/{what}", data, Origin=served.address.rstrip("/"))
    return status, json.loads(body)


def begin(page: Any, served: Served, minutes: float) -> Any:
    """Ask for an investigation, and return the dialog before its first motion."""
    page.goto(served.address + "#investigate")
    page.get_by_label("Minutes of motion").fill(str(minutes))
    page.locator("#view").get_by_role("button", name="Investigate").click()
    dialog = page.get_by_role("dialog")
    dialog.wait_for(timeout=LONG)
    return dialog


def test_it_needs_limits_and_refuses_wrong_ones(served: Served, page: Any, tmp_path: Path) -> None:
    page.goto(served.address + "#investigate")
    page.get_by_text("Say where the arm may go").wait_for(timeout=LONG)
    start = page.locator("#view").get_by_role("button", name="Investigate")
    assert start.is_disabled()
    wrong, right = tmp_path / "wrong.yaml", tmp_path / "limits.yaml"
    wrong.write_text("joint_limits: {a: {min_position: 0.0}}")
    page.set_input_files("#limits", str(wrong))
    page.get_by_text("wrong.yaml: a has no max_position").wait_for()
    assert start.is_disabled()
    right.write_text(LIMITS)
    page.set_input_files("#limits", str(right))
    playwright.expect(start).to_be_enabled()
    assert page.get_by_label("Topic").input_value() == TOPIC


def test_nothing_moves_before_it_is_permitted_and_the_larger_range_is_asked_for(
    served: Served, driver: Driver, page: Any
) -> None:
    dialog = begin(page, served, 0.3)
    words = dialog.inner_text()
    for expected in ("a, b", TOPIC, "/driver", "up to 18 s", "50 % of the way", "-0.450"):
        assert expected in words
    assert page.locator(":focus").inner_text() == "Do not move"
    page.keyboard.press("Escape")
    page.locator("#view").get_by_text("It waits for your permission to move").wait_for()
    _, shown = asked(served, "ask/question")
    assert asked(served, "ask/permit", token="guessed")[0] == 400
    body = json.dumps({"token": shown["token"]}).encode()
    assert served.asked("api/ask/permit", body, Origin="http://example.org")[0] == 403
    assert served.asked("api/ask/permit", body)[0] == 403
    status, answer = asked(served, "live/prepare", motion="any.csv", topic=TOPIC)
    assert (status, "investigation moves the arm" in answer["error"]) == (400, True)
    time.sleep(0.3)
    assert not driver.came
    page.reload()
    dialog.wait_for(timeout=LONG)
    page.get_by_role("button", name="Move the arm").click()
    page.get_by_text("Move the arm farther?").wait_for(timeout=LONG)
    assert len(driver.came) == 1
    assert asked(served, "ask/permit", token=shown["token"])[0] == 400, "it was for the first range"
    assert "up to the limits" in dialog.inner_text()
    page.get_by_role("button", name="Move the arm").click()
    page.get_by_text("It ended").first.wait_for(timeout=LONG)
    told = page.get_by_role("heading", name="In the end")
    assert told.is_visible(), page.locator("#view").inner_text()
    idle(page)
    assert len(driver.came) == 2
    first, second = (np.abs(path_of(one).q).max(axis=0) for one in driver.came)
    assert (first <= [0.46, 0.56]).all()
    assert (second > first).all()
    words = page.locator("#view").inner_text()
    assert "What does the arm do?" in words
    assert "Its 2 motions are cards under Data" in words
    page.get_by_role("button", name="Go to its steps").click()
    errors = page.locator("#view table").first.locator("tbody tr").first
    assert float(errors.locator("td.total").inner_text()) > 0.0
    page.goto(served.address + "#data")
    playwright.expect(page.locator("article", has_text="investigation 1, motion")).to_have_count(2)


def test_a_stop_brings_it_to_rest_on_its_path(
    served: Served, driver: Driver, page: Any, browser: Any
) -> None:
    driver.came.clear()
    dialog = begin(page, served, 0.4)
    for scheme in ("light", "dark"):
        for other in opened(browser, bypass_csp=True, color_scheme=scheme):
            other.goto(served.address + "#investigate")
            other.get_by_role("dialog").wait_for(timeout=LONG)
            assert not violations(other), scheme
    dialog.get_by_role("button", name="Move the arm").click()
    page.goto(served.address + "#data")
    end = time.monotonic() + LONG / 1000
    while np.abs(driver.velocity).max() < 0.1:
        assert time.monotonic() < end
        time.sleep(0.02)
    page.get_by_role("button", name="Stop the arm").click()
    came = time.monotonic()
    while np.abs(driver.velocity).max() > 0.0:
        assert time.monotonic() < came + 3.0
        time.sleep(0.02)
    page.goto(served.address + "#investigate")
    page.get_by_text("stopped by the user").first.wait_for(timeout=LONG)
    idle(page)
    assert len(driver.came) == 2
    assert path_of(driver.came[-1]).duration < 1.0  # a stop, and no other motion
    assert served.stop() == 0
