"""What tests do in a browser, some of it to be made a fixture: open pages, wait, and click."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from workbench_examples import Served, moved

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
LONG = 90_000  # ms
needs_chromium = pytest.mark.skipif(
    CHROMIUM is None, reason="there is no Chromium: apt install chromium"
)


def chromium() -> Iterator[Any]:
    """Yield a browser."""
    playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    with playwright.sync_playwright() as driver:
        made = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield made
        made.close()


def three_motions(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Return recordings to learn from, to search and to confirm with."""
    folder = tmp_path_factory.mktemp("recordings")
    return [moved(folder / f"motion_{seed}.npz", seed) for seed in range(3)]


def opened(browser: Any, **options: Any) -> Iterator[Any]:
    """Yield a page that says nothing on the console."""
    made = browser.new_page(viewport={"width": 1366, "height": 768}, **options)
    errors: list[str] = []
    made.on("pageerror", lambda error: errors.append(str(error)))
    made.on("console", lambda line: errors.append(line.text) if line.type == "error" else None)
    yield made
    made.close()
    said = [error for error in errors if "Failed to load resource" not in error]
    assert not said, said


def idle(page: Any) -> None:
    """Wait until the page has shown no work for half a second.

    Work redraws the page when it begins and when it ends.
    """
    page.evaluate("window.worked = performance.now()")
    page.wait_for_function(
        """() => {
            if (document.querySelector("#work progress")) window.worked = performance.now();
            return performance.now() - window.worked > 500;
        }""",
        timeout=LONG,
    )


def shown(page: Any, served: Served) -> None:
    """Open the page of a workbench, and wait until its recordings are read."""
    page.goto(served.address)
    page.wait_for_selector("article .joints", timeout=LONG)
    idle(page)


def learn(page: Any) -> None:
    """Click for a model, and wait for it and its comparison."""
    page.get_by_role("button", name="Learn a model").click()
    page.get_by_role("button", name="See where it fails").wait_for(timeout=LONG)
    idle(page)


def uploaded(page: Any, files: list[Path]) -> None:
    """Choose files, and wait until they are read."""
    page.set_input_files("#choose", [str(file) for file in files])
    page.wait_for_selector(f"article .joints >> nth={len(files) - 1}", timeout=LONG)
    idle(page)


def violations(page: Any) -> list[tuple[str, str]]:
    """Return what axe finds on a page that was opened with `bypass_csp`."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    found = axe.Axe().run(page).response["violations"]
    return [(one["id"], one["impact"]) for one in found]
