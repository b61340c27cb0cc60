"""The page beside a running arm: curves stream, recordings become cards, motions are confirmed."""

import json
import os
import re
import shutil
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from scripted_arm import JOINTS, TOPIC, Driver, driving
from workbench_examples import Served, moved, serving

from lagrangian_ff.arm.trajectory import Trajectory, write_trajectory

playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = pytest.mark.skipif(
    CHROMIUM is None, reason="there is no Chromium: apt install chromium"
)
LONG = 60_000  # ms
DRAG = 0.9


@pytest.fixture(scope="module")
def driver(ros_environment: dict[str, str]) -> Iterator[Driver]:
    with driving(DRAG) as made:
        yield made


@pytest.fixture(scope="module")
def served(driver: Driver, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """Return a workbench with a model and a motion, beside the scripted arm."""
    folder = tmp_path_factory.mktemp("live")
    source = moved(folder / "motion.npz", 0, DRAG)
    (folder / "session" / "motions").mkdir(parents=True)
    q = np.array([[0.0, 0.0], [0.6, 0.3], [0.0, 0.0]])
    still = np.zeros_like(q)
    motion = Trajectory(np.array([0.0, 3.0, 6.0]), q, still, still, JOINTS)
    write_trajectory(folder / "session" / "motions" / "back_and_forth.csv", motion)
    for serve in serving():
        yield serve(folder / "session", "--live", source)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with playwright.sync_playwright() as started:
        made = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield made
        made.close()


@pytest.fixture
def page(browser: Any, served: Served) -> Iterator[Any]:
    yield from opened(browser, served)


def opened(browser: Any, served: Served, **options: Any) -> Iterator[Any]:
    """Yield the page at the step Live, with no error on the console."""
    made = browser.new_page(viewport={"width": 1366, "height": 768}, **options)
    errors: list[str] = []
    made.on("pageerror", lambda error: errors.append(str(error)))
    made.goto(served.address + "#live")
    made.get_by_text("/joint_states, ").wait_for(timeout=LONG)
    yield made
    made.close()
    assert not errors


def asked(served: Served, what: str, **question: Any) -> tuple[int, dict[str, Any]]:
    """Return the answer to what the page could ask."""
    origin = served.address.rstrip("/")
    data = json.dumps(question).encode()
    status, body = served.asked(f"api/live/{what}", data, Origin=origin)
    return status, json.loads(body)


def confirmed(page: Any) -> Any:
    """Click for the confirmation of the motion, and return its dialog."""
    page.get_by_role("button", name="Send…").click()
    dialog = page.get_by_role("dialog")
    dialog.wait_for(timeout=LONG)
    return dialog


def test_the_torque_streams_and_then_what_the_model_leaves(
    served: Served, driver: Driver, page: Any
) -> None:
    canvas = page.locator("canvas")
    canvas.wait_for(timeout=LONG)
    before = canvas.screenshot()
    page.wait_for_timeout(500)
    assert canvas.screenshot() != before
    page.get_by_role("button", name="b", exact=True).click()
    page.goto(served.address + "#data")
    page.get_by_role("button", name="Learn a model").click()
    page.get_by_role("button", name="See where it fails").wait_for(timeout=LONG)
    page.goto(served.address + "#live")
    row = page.locator("section", has_text="Residual").locator("tbody tr").last
    for n in (1, 3):
        expected = re.compile(r"^[0-9.]+$")
        playwright.expect(row.locator("td").nth(n)).to_have_text(expected, timeout=LONG)
    unseen, ratio = (float(row.locator("td").nth(n).inner_text()) for n in (2, 3))
    assert unseen > 0.0
    assert 0.2 < ratio < 3.0, "the arm moves as in the recording"


def test_a_recording_becomes_a_card(served: Served, driver: Driver, page: Any) -> None:
    page.get_by_role("button", name="Start recording").click()
    page.get_by_text("● recording, 2 s").wait_for(timeout=LONG)
    page.get_by_role("button", name="Stop recording").click()
    page.get_by_text("they are a card under Data").wait_for(timeout=LONG)
    page.get_by_role("button", name="Start recording").wait_for()
    page.goto(served.address + "#data")
    card = page.locator("article", has_text="live ")
    card.get_by_text("2 joints").wait_for(timeout=LONG)
    assert (served.session / "recordings").is_dir()


def answered_late(route: Any) -> None:
    """Let a page hear that a motion began before it hears that it was sent."""
    answer = route.fetch()
    time.sleep(0.5)
    route.fulfill(response=answer)


def test_the_focus_stays_while_the_view_is_made_again(
    served: Served, driver: Driver, page: Any
) -> None:
    send = page.get_by_role("button", name="Send…")
    driver.moving, driver.q = False, np.array([0.1, 0.0])

    def made_again() -> None:
        old = page.locator("[data-key=prepare]").element_handle()
        for what in ("record", "finish"):
            status, answer = asked(served, what)
            assert status == 200, answer
            page.wait_for_timeout(500)
        page.wait_for_function("one => !one.isConnected", arg=old, timeout=LONG)

    send.focus()
    made_again()
    playwright.expect(send).to_be_focused()
    held: list[Any] = []
    page.route("**/api/live/prepare", lambda route: held.append(route))
    send.click()
    made_again()
    held[0].continue_()
    dialog = page.get_by_role("dialog")
    dialog.wait_for(timeout=LONG)
    page.keyboard.press("Escape")
    playwright.expect(dialog).to_have_count(0)
    playwright.expect(send).to_be_focused()


def test_a_motion_is_sent_after_its_confirmation_and_not_without(
    served: Served, driver: Driver, page: Any
) -> None:
    driver.moving, driver.q = False, np.array([0.1, 0.0])
    page.wait_for_timeout(600)
    dialog = confirmed(page)
    words = dialog.inner_text()
    for expected in ("Move the arm: back and forth?", "a, b", TOPIC, "/driver", "a by -0.100"):
        assert expected in words
    focused = page.locator(":focus")
    assert focused.inner_text() == "Do not send"
    page.keyboard.press("Escape")
    playwright.expect(dialog).to_have_count(0)
    playwright.expect(page.get_by_role("button", name="Send…")).to_be_focused()

    motion = {"motion": "back_and_forth.csv", "topic": TOPIC}
    assert asked(served, "send", token="guessed", **motion)[0] == 400
    status, shown = asked(served, "prepare", **motion)
    assert status == 200
    for forged in ({"topic": "/other"}, {"motion": "other.csv"}):
        given = {**motion, "token": shown["token"], **forged}
        status, answer = asked(served, "send", **given)
        assert status == 400
        assert "confirmed" in answer["error"]
    stale = shown["token"]
    status, shown = asked(served, "prepare", **motion)
    assert asked(served, "send", token=stale, **motion)[0] == 400
    for file in ("../../x.csv", "/etc/passwd", ""):
        assert asked(served, "prepare", motion=file, topic=TOPIC)[0] == 400
    body = json.dumps({**motion, "token": shown["token"]}).encode()
    assert served.asked("api/live/send", body, Origin="http://example.org")[0] == 403
    assert served.asked("api/live/send", body)[0] == 403
    time.sleep(0.3)
    assert not driver.came

    confirmed(page)
    page.route("**/api/live/send", answered_late)
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    stop = page.get_by_role("button", name="Stop the motion")
    stop.wait_for(timeout=LONG)
    assert len(driver.came) == 1
    assert list(driver.came[0].points[0].positions) == [0.1, 0.0]
    playwright.expect(stop).to_be_focused()
    page.goto(served.address + "#data")
    stop.click()
    playwright.expect(stop).to_have_count(0)
    assert len(driver.came) >= 2


def test_what_is_impossible_is_said_in_words(served: Served, driver: Driver, page: Any) -> None:
    driver.moving = True
    page.wait_for_timeout(600)
    page.get_by_role("button", name="Send…").click()
    page.get_by_text("moves now: wait until the arm stands").wait_for(timeout=LONG)
    assert page.get_by_role("dialog").count() == 0
    driver.moving = False


def test_axe_finds_nothing_serious(served: Served, driver: Driver, browser: Any) -> None:
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    driver.moving = False
    for scheme in ("light", "dark"):
        options = {"bypass_csp": True, "color_scheme": scheme}
        for page in opened(browser, served, **options):
            page.wait_for_timeout(600)
            for look in (lambda: None, lambda page=page: confirmed(page)):
                look()
                violations = axe.Axe().run(page).response["violations"]
                assert not [(one["id"], one["impact"]) for one in violations], scheme


def children(pid: int) -> list[int]:
    """Return the processes that a process started."""
    return [int(one) for one in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def test_a_lost_connection_is_said_and_can_be_made_again(
    served: Served, driver: Driver, page: Any
) -> None:
    for pid in children(served.pid):
        if b"lagrangian_ff.nodes.live" in Path(f"/proc/{pid}/cmdline").read_bytes():
            os.kill(pid, signal.SIGKILL)
    page.get_by_text("The process in the ROS graph has ended", exact=False).wait_for(timeout=LONG)
    assert page.get_by_role("button", name="Start recording").is_disabled()
    page.get_by_role("button", name="Connect again").click()
    page.get_by_text("/joint_states, ").wait_for(timeout=LONG)
    assert served.stop() == 0


def test_a_killed_workbench_keeps_its_recording(
    driver: Driver, browser: Any, tmp_path: Path
) -> None:
    driver.moving = True
    for serve in serving():
        served = serve(tmp_path / "session", "--live")
        for page in opened(browser, served):
            page.get_by_role("button", name="Start recording").click()
            page.get_by_text("● recording, 2 s").wait_for(timeout=LONG)
        served.stop(signal.SIGKILL)
        again = serve(tmp_path / "session", "--live")
        for page in opened(browser, again):
            page.goto(again.address + "#data")
            page.locator("article", has_text="live ").get_by_text("2 joints").wait_for(timeout=LONG)
        assert again.stop() == 0
