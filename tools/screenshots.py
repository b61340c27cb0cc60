"""Make the pictures of the workbench in docs/pictures, as a user walks through it.

    .venv/bin/python tools/screenshots.py

Needs Chromium. It also prints the time and the clicks from the first page to the fallen error.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parent.parent
PICTURES = ROOT / "docs" / "pictures"
LONG = 120_000  # ms
RUN = "import sys; from lagrangian_ff.cli.main import main; sys.exit(main(sys.argv[1:]))"


def started(session: Path) -> tuple[subprocess.Popen[str], str]:
    """Return the process of a workbench and the address of its page."""
    command = [sys.executable, "-u", "-c", RUN, "workbench", "--try", "--no-browser"]
    command += ["--port", "0", "--session", str(session)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    for line in process.stdout:
        if found := re.match(r"workbench: (http\S+)", line):
            return process, found[1]
    raise SystemExit("the workbench did not start")


def idle(page: Any) -> None:
    """Wait until the work is done."""
    page.wait_for_timeout(400)
    page.wait_for_selector("#work progress", state="detached", timeout=LONG)
    page.wait_for_timeout(400)


def walk(page: Any, address: str, name: str) -> None:
    """Go from recordings to the fallen error, with a picture of each step."""

    def picture(step: str) -> None:
        page.screenshot(path=PICTURES / f"workbench_{step}{name}.png")

    began, clicks = time.monotonic(), 0

    def click(text: str) -> None:
        nonlocal clicks
        clicks += 1
        page.locator("#view").get_by_role("button", name=text).first.click()

    page.goto(address)
    page.wait_for_selector("article .joints >> nth=2", timeout=LONG)
    idle(page)
    picture("data")
    click("Learn a model")
    page.get_by_role("button", name="See where it fails").wait_for(timeout=LONG)
    idle(page)
    picture("model")
    click("See where it fails")
    page.wait_for_timeout(600)
    page.locator(".regions button").first.click()
    page.wait_for_timeout(400)
    picture("compare")
    click("Find what is missing")
    click("Find what is missing")
    page.get_by_role("button", name="Add it").first.wait_for(timeout=LONG)
    idle(page)
    picture("diagnose")
    click("Add it")
    idle(page)
    picture("steps")
    print(f"{time.monotonic() - began:.0f} s and {clicks} clicks to the fallen error")
    click("Take it away")
    page.wait_for_timeout(400)
    picture("take")


def main() -> int:
    """Make the pictures and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else "")
    parser.add_argument("--width", type=int, default=1366)
    parser.add_argument("--height", type=int, default=768)
    parser.add_argument("--dark", action="store_true", help="in dark colours")
    parser.add_argument("--name", default="", help="added to the pictures' names")
    given = parser.parse_args()
    chromium = shutil.which("chromium")
    if chromium is None:
        raise SystemExit("there is no Chromium: apt install chromium")
    with tempfile.TemporaryDirectory() as folder:
        process, address = started(Path(folder) / "session")
        try:
            with sync_playwright() as driver:
                browser = driver.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
                page = browser.new_page(
                    viewport={"width": given.width, "height": given.height},
                    color_scheme="dark" if given.dark else "light",
                )
                walk(page, address, given.name)
                browser.close()
        finally:
            process.terminate()
            process.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())
