"""The page in a real browser: from an upload to the fallen error, and back again."""

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from browsing import (
    LONG,
    chromium,
    idle,
    learn,
    needs_chromium,
    opened,
    shown,
    three_motions,
    uploaded,
    violations,
)
from workbench_examples import Served, serving

from lagrangian_ff.arm import read_trajectory
from lagrangian_ff.identification import Model

playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
pytestmark = needs_chromium
serve = pytest.fixture(serving)
browser = pytest.fixture(scope="module")(chromium)
recordings = pytest.fixture(scope="module")(three_motions)
page = pytest.fixture(opened)
PLAIN = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])}
STEPS = ("data", "model", "compare", "diagnose", "history", "take")


@pytest.fixture(scope="module")
def found(
    browser: Any, recordings: list[Path], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Served]:
    """Return a workbench in which the missing effect was found, by clicks alone, and added."""
    for serve in serving():
        served = serve(tmp_path_factory.mktemp("bench") / "session")
        for page in opened(browser):
            page.goto(served.address)
            page.get_by_text("Drop recordings here").wait_for()
            uploaded(page, recordings)
            learn(page)
            page.get_by_role("button", name="See where it fails").click()
            page.get_by_role("button", name="Find what is missing").click()
            page.locator("#view").get_by_role("button", name="Find what is missing").click()
            add = page.get_by_role("button", name="Add it").first
            add.wait_for(timeout=LONG)
            page.get_by_text("quadratic drag on b", exact=False).first.wait_for()
            add.click()
            idle(page)
        yield served


def errors_shown(page: Any) -> list[float]:
    """Return the error of each step over all joints."""
    rows = page.locator("#view table").first.locator("tbody tr").all()
    return [float(row.locator("td.total").inner_text()) for row in rows]


def test_the_error_falls_and_the_step_can_be_undone(found: Served, page: Any) -> None:
    page.goto(found.address + "#history")
    page.get_by_role("button", name="Undo").wait_for()
    before, after = errors_shown(page)
    assert after < 0.6 * before
    page.get_by_text("confirmed, log Bayes factor").wait_for()
    change = page.locator("section", has_text="Two models").locator("tbody tr").last
    assert "-" in change.locator("td").last.inner_text()
    page.get_by_role("button", name="Undo").click()
    playwright.expect(page.locator("#view table").first.locator("tbody tr")).to_have_count(1)
    page.get_by_role("button", name="Redo").click()
    playwright.expect(page.locator("#view table").first.locator("tbody tr")).to_have_count(2)


def test_the_model_can_be_taken_away(found: Served, page: Any, tmp_path: Path) -> None:
    page.goto(found.address + "#take")
    with page.expect_download() as download:
        page.get_by_role("link", name="Save the model").click()
    download.value.save_as(tmp_path / "model.npz")
    assert "quadratic_drag" in Model.load(tmp_path / "model.npz").name
    for name, words in (("Page of the comparison", "<html"), ("Save as YAML", "joints: [a, b]")):
        with page.expect_download() as download:
            page.locator("#view").get_by_text(name).click()
        assert words in Path(download.value.path()).read_text()
    page.goto(found.address + "#history")
    with page.expect_download() as download:
        page.get_by_role("button", name="save the figure steps").click()
    assert Path(download.value.path()).read_text().startswith("<svg")
    page.goto(found.address + "#take")
    commands = page.locator("pre").last.inner_text()
    assert "lagrangian_ff add model.npz quadratic_drag --joint b" in commands


def test_two_tabs_do_not_disturb_each_other(found: Served, page: Any, browser: Any) -> None:
    page.goto(found.address + "#compare")
    page.get_by_role("button", name="a", exact=True).click()
    for other in opened(browser):
        other.goto(found.address + "#compare")
        theirs = other.get_by_role("button", name="a", exact=True)
        theirs.wait_for()
        ours = page.get_by_role("button", name="a", exact=True)
        assert theirs.get_attribute("aria-pressed") == "true"
        assert ours.get_attribute("aria-pressed") == "false"
        other.goto(found.address + "#data")
    page.get_by_role("heading", name="Where does it fail?").wait_for()


def drawn(page: Any) -> str:
    """Return the picture of the first curves once it stays as it is, whoever redraws the page."""
    picture = ""
    for _ in range(30):
        before, picture = picture, page.evaluate("document.querySelector('canvas').toDataURL()")
        if picture == before:
            return picture
        page.wait_for_timeout(300)
    raise AssertionError("the curves do not come to rest")


def test_the_curves_zoom_by_keys_and_keep_their_window(found: Served, page: Any) -> None:
    page.goto(found.address + "#compare")
    curves = page.locator("canvas").first
    curves.wait_for()
    idle(page)
    whole = drawn(page)
    curves.focus()
    page.keyboard.press("+")
    assert drawn(page) != whole
    page.keyboard.press("Home")
    assert drawn(page) == whole


def test_a_region_and_a_part_of_the_map_light_up_in_the_curves(found: Served, page: Any) -> None:
    page.goto(found.address + "#history")
    page.get_by_role("button", name="learned").click()
    playwright.expect(page.locator("#view table").first.locator("tbody tr")).to_have_count(1)
    page.goto(found.address + "#compare")
    page.locator(".regions button").first.click()
    page.get_by_text("Marked: b").wait_for()
    page.locator("canvas").last.focus()
    page.keyboard.press("Enter")
    page.get_by_text("Marked: ", exact=False).wait_for()
    assert " stretches." in page.get_by_text("Marked: ").inner_text()
    page.get_by_label("across").select_option(label="position of a")
    page.wait_for_timeout(200)
    page.goto(found.address + "#history")
    page.get_by_role("button", name="quadratic drag").click()


def test_a_map_that_has_not_come_yet_chooses_nothing(found: Served, page: Any) -> None:
    page.route("**/api/map/**", lambda route: None)
    page.goto(found.address + "#compare")
    page.locator("canvas").last.focus()
    page.keyboard.press("Enter")
    assert page.get_by_text("Marked: ").count() == 0


def test_news_do_not_break_a_drag(found: Served, page: Any, browser: Any) -> None:
    page.goto(found.address + "#compare")
    curves = page.locator("canvas").first
    curves.wait_for()
    idle(page)
    dragged = curves.element_handle()
    box = curves.bounding_box()
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 40)
    page.mouse.down()
    for other in opened(browser):
        other.goto(found.address + "#history")
        other.get_by_role("button", name="learned").click()
        playwright.expect(other.locator("#view table").first.locator("tbody tr")).to_have_count(1)
        page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 40)
        assert dragged.evaluate("canvas => canvas.isConnected")
        page.mouse.up()
        page.wait_for_function("canvas => !canvas.isConnected", arg=dragged)
        other.get_by_role("button", name="quadratic drag").click()
        idle(other)


def test_a_stretch_of_time_is_marked_by_mouse_and_keys(found: Served, page: Any) -> None:
    page.goto(found.address + "#compare")
    curves = page.locator("canvas").first
    curves.wait_for()
    idle(page)
    page.get_by_role("button", name="mark", exact=True).click()
    map_ = page.locator("canvas").last
    dark = map_.screenshot()
    curves.scroll_into_view_if_needed()
    box = curves.bounding_box()
    with page.expect_response(lambda answer: "/api/lit/" in answer.url) as lit:
        page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 40)
        page.mouse.down()
        page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 40)
        page.mouse.up()
    assert lit.value.json()["bins"]
    page.get_by_text("in 1 stretch.").wait_for()
    page.wait_for_timeout(200)
    assert map_.screenshot() != dark
    curves.focus()
    page.keyboard.press("+")
    page.wait_for_timeout(300)
    with page.expect_response(lambda answer: "/api/lit/" in answer.url) as lit:
        page.keyboard.press("m")
    assert lit.value.ok


def test_the_next_motion_is_drawn_and_saved(found: Served, page: Any, tmp_path: Path) -> None:
    page.goto(found.address + "#diagnose")
    start = page.locator("#view").get_by_role("button", name=re.compile("Find what|Look again"))
    start.click()
    idle(page)
    page.locator("summary", has_text="cannot show").click()
    page.get_by_role("button", name="Make this motion").first.click()
    page.get_by_role("heading", name="The next motion").wait_for(timeout=LONG)
    assert page.get_by_text(re.compile(r"Unseen error of [ab]: ")).count() >= 1
    assert page.locator("section.finding svg path").count() >= 1
    with page.expect_download() as download:
        page.get_by_role("link", name="Save the motion").click()
    download.value.save_as(tmp_path / "motion.csv")
    motion = read_trajectory(tmp_path / "motion.csv")
    assert set(motion.joints) == {"a", "b"}
    assert (abs(motion.q) <= 0.95).all()
    assert not motion.qd[[0, -1]].any()


def test_every_combination_is_tried(found: Served, page: Any) -> None:
    page.goto(found.address + "#history")
    page.get_by_role("button", name="learned").click()
    playwright.expect(page.locator("#view table").first.locator("tbody tr")).to_have_count(1)
    page.goto(found.address + "#diagnose")
    page.get_by_role("button", name="Try all combinations").click()
    page.get_by_text("without any of them").wait_for(timeout=LONG)
    page.get_by_label("quadratic drag on b").check()
    page.get_by_text("% against none of them").wait_for()
    assert "-" in page.get_by_text("% against none of them").inner_text()
    page.goto(found.address + "#history")
    page.get_by_role("button", name="quadratic drag").first.click()


def test_a_formula_of_ones_own_is_found_and_added(
    recordings: list[Path], page: Any, tmp_path: Path, serve: Callable[..., Served]
) -> None:
    served = serve(tmp_path / "session", *recordings[:1])
    shown(page, served)
    learn(page)
    before = page.locator("#steps button").nth(2).inner_text()
    page.goto(served.address + "#diagnose")
    page.get_by_label("Name").fill("my_drag")
    page.get_by_label("Torque").fill("__import__('os')")
    page.get_by_role("button", name="Take it into the search").click()
    page.get_by_text("expected numbers").wait_for()
    page.get_by_label("Torque").fill("K*qd*abs(qd)^p")
    page.get_by_label("Ranges").fill("p: 0.5 to 2")
    page.get_by_role("button", name="Take it into the search").click()
    page.get_by_label("joint of my_drag").select_option("b")
    page.locator(".own").get_by_role("button", name="Add it").click()
    idle(page)
    playwright.expect(page.locator("#view table").first.locator("tbody tr")).to_have_count(2)
    first, last = errors_shown(page)
    assert last < 0.7 * first, before
    page.goto(served.address + "#take")
    assert "effects_file: " in page.locator("pre").first.inner_text()
    commands = page.locator("pre").last.inner_text()
    assert served.stop() == 0
    begin = f'set -e; lagrangian_ff() {{ {sys.executable} -m lagrangian_ff.cli "$@"; }}'
    shell = ["bash", "-c", f"{begin}; cd {tmp_path}; {commands}"]
    text = subprocess.run(shell, check=True, capture_output=True, text=True, env=PLAIN).stdout
    *_, error = re.findall(r"^ *all joints +([\d.]+)", text, re.MULTILINE)
    assert float(error) == pytest.approx(last, rel=0.02)


def test_a_killed_server_loses_nothing(
    recordings: list[Path], page: Any, tmp_path: Path, serve: Callable[..., Served]
) -> None:
    served = serve(tmp_path / "session", *recordings[:1])
    shown(page, served)
    learn(page)
    served.stop(signal.SIGKILL)
    again = serve(tmp_path / "session")
    page.goto(again.address + "#model")
    page.get_by_role("button", name="See where it fails").wait_for()
    page.reload()
    page.get_by_role("button", name="See where it fails").wait_for()
    assert again.stop() == 0


def test_work_can_be_cancelled(
    recordings: list[Path], page: Any, tmp_path: Path, serve: Callable[..., Served]
) -> None:
    served = serve(tmp_path / "session", *recordings[:1])
    shown(page, served)
    page.get_by_role("button", name="Learn a model").click()
    page.get_by_role("button", name="Cancel", exact=True).click()
    page.get_by_text("learning a model: cancelled").wait_for()
    page.get_by_text("not learned yet").wait_for()
    served.stop()


def test_what_is_no_recording_is_said_on_its_card(
    page: Any, tmp_path: Path, serve: Callable[..., Served]
) -> None:
    wrong = tmp_path / "notes.csv"
    wrong.write_text("this is no recording\n")
    served = serve(tmp_path / "session")
    page.goto(served.address)
    page.get_by_text("Drop recordings here").wait_for()
    page.set_input_files("#choose", str(wrong))
    page.locator("article .bad").wait_for(timeout=LONG)
    assert "expected" in page.locator("article .bad").inner_text()
    assert page.get_by_role("button", name="Learn a model").is_disabled()
    page.get_by_role("button", name="take notes.csv away").click()
    page.get_by_text("Drop recordings here").wait_for()
    assert not list((tmp_path / "session" / "recordings").iterdir())
    served.stop()


def test_all_can_be_done_with_the_keyboard(
    recordings: list[Path], page: Any, tmp_path: Path, serve: Callable[..., Served]
) -> None:
    served = serve(tmp_path / "session", *recordings)
    shown(page, served)
    for name in ("Learn a model", "See where it fails", *2 * ("Find what is missing",), "Add it"):
        page.locator("#view").get_by_role("button", name=name).first.wait_for(timeout=LONG)
        idle(page)
        for _ in range(60):
            page.keyboard.press("Tab")
            if page.locator("#view button:focus").all_inner_texts() == [name]:
                break
        page.keyboard.press("Enter")
    idle(page)
    first, last = errors_shown(page)
    assert last < 0.6 * first
    served.stop()


def test_axe_finds_nothing_serious(found: Served, browser: Any) -> None:
    for scheme in ("light", "dark"):
        for page in opened(browser, bypass_csp=True, color_scheme=scheme):
            for step in STEPS:
                page.goto(f"{found.address}#{step}")
                page.wait_for_selector("#view h2")
                page.wait_for_timeout(300)
                assert not violations(page), (scheme, step)
