"""What no effect fits, in a real browser: taken in as a curve, then replaced by a formula."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browsing import LONG, chromium, idle, learn, needs_chromium, opened, shown, violations
from workbench_examples import Served, moved, serving

from lagrangian_ff.effects.user import load_effects

playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
pytestmark = needs_chromium
browser = pytest.fixture(scope="module")(chromium)
page = pytest.fixture(opened)
PLAIN = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])}


@pytest.fixture(scope="module")
def served(browser: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """Return a workbench that has looked at an arm with a friction that nobody listed."""
    folder = tmp_path_factory.mktemp("unlisted")
    sources = [moved(folder / f"{n}.npz", n, 0.0, 20.0, rough=0.8) for n in range(3)]
    for serve in serving():
        served = serve(folder / "session", *sources)
        for page in opened(browser):
            shown(page, served)
            learn(page)
            page.goto(served.address + "#diagnose")
            page.locator("#view").get_by_role("button", name="Find what is missing").click()
            page.get_by_role("heading", name="Unexplained on b").wait_for(timeout=LONG)
            idle(page)
        yield served


def errors_shown(page: Any, served: Served) -> list[float]:
    """Return the error of each step over all joints."""
    page.goto(served.address + "#history")
    idle(page)
    rows = page.locator("#view table").first.locator("tbody tr").all()
    return [float(row.locator("td.total").inner_text()) for row in rows]


def repeated(page: Any, served: Served, folder: Path) -> float:
    """Return the error over all joints that the commands to take away come to in a shell."""
    page.goto(served.address + "#take")
    commands = page.locator("pre").last.inner_text()
    begin = f'set -e; lagrangian_ff() {{ {sys.executable} -m lagrangian_ff.cli "$@"; }}'
    shell = ["bash", "-c", f"{begin}; cd {folder}; {commands}"]
    text = subprocess.run(shell, check=True, capture_output=True, text=True, env=PLAIN).stdout
    *_, error = re.findall(r"^ *all joints +([\d.]+)", text, re.MULTILINE)
    return float(error)


def test_a_curve_is_a_step_that_can_be_undone(served: Served, page: Any, tmp_path: Path) -> None:
    page.goto(served.address + "#diagnose")
    page.get_by_text("changing sign with direction, and no effect").wait_for()
    page.get_by_role("button", name="Take the curve in").click()
    page.get_by_text("+ curve over position").first.wait_for(timeout=LONG)
    before, after = errors_shown(page, served)
    assert after < 0.2 * before
    page.get_by_text("unexplained, log Bayes factor").wait_for()
    assert repeated(page, served, tmp_path) == pytest.approx(after, rel=0.02)
    page.goto(served.address + "#history")
    page.get_by_role("button", name="Undo").click()
    playwright.expect(page.locator("#view table").first.locator("tbody tr")).to_have_count(1)
    page.get_by_role("button", name="Redo").click()
    playwright.expect(page.locator("#view table").first.locator("tbody tr")).to_have_count(2)


@pytest.mark.usefixtures("catalogue_kept")
def test_formulas_are_proposed_and_one_takes_the_place_of_the_curve(
    served: Served, page: Any, browser: Any, tmp_path: Path
) -> None:
    page.goto(served.address + "#diagnose")
    propose = page.get_by_role("button", name="Propose formulas")
    propose.click()
    page.get_by_role("button", name="Cancel", exact=True).click()
    page.get_by_text("proposing formulas for b: cancelled").wait_for()
    propose.click()
    card = page.locator("article", has_text="A formula for b").first
    card.wait_for(timeout=LONG)
    idle(page)
    words = card.inner_text()
    for expected in ("sign(qd)*(A*cos(n*q)+B*sin(n*q))", "N·m (", "times a turn", "confirmed"):
        assert expected in words
    page.reload()
    card.wait_for(timeout=LONG)
    card.get_by_role("button", name="Add", exact=True).click()
    page.get_by_text("+ formula friction wave position on b").first.wait_for(timeout=LONG)
    errors = errors_shown(page, served)
    assert len(errors) == 2, "the curve is not below it"
    assert errors[1] < 0.2 * errors[0]
    assert repeated(page, served, tmp_path) == pytest.approx(errors[1], rel=0.02)
    with page.expect_download() as download:
        page.get_by_role("button", name="Save the formulas").click()
    download.value.save_as(tmp_path / "mine.json")
    (effect,) = load_effects(tmp_path / "mine.json")
    assert effect.name == "formula_friction_wave_position"
    assert effect.parameters[0].unit == "N·m"
    assert json.loads((served.session / "formulas.json").read_text())["effects"]
    page.goto(served.address + "#diagnose")
    page.get_by_label("joint of formula_friction_wave_position").wait_for()


def test_axe_finds_nothing_serious(served: Served, browser: Any) -> None:
    for scheme in ("light", "dark"):
        for page in opened(browser, bypass_csp=True, color_scheme=scheme):
            for model, words in (("learned", "Unexplained on b"), ("+ curve", "A formula for b")):
                page.goto(served.address + "#history")
                page.get_by_role("button", name=re.compile(re.escape(model))).click()
                page.goto(served.address + "#diagnose")
                page.get_by_role("heading", name=words).first.wait_for()
                assert not violations(page), (scheme, words)
