"""Make the pictures of the workbench in docs/pictures, as a user walks through it.

    .venv/bin/python tools/screenshots.py
    .venv/bin/python tools/screenshots.py --live       beside the simulated arm, in ROS 2
    .venv/bin/python tools/screenshots.py --unlisted   an effect that no catalogue has

Needs Chromium. It also prints the time and the clicks from the first page to the fallen error.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parent.parent
PICTURES = ROOT / "docs" / "pictures"
LONG = 120_000  # ms
RUN = "import sys; from lagrangian_ff.cli.main import main; sys.exit(main(sys.argv[1:]))"


def started(session: Path, *more: str) -> tuple[subprocess.Popen[str], str]:
    """Return the process of a workbench and the address of its page."""
    command = [sys.executable, "-u", "-c", RUN, "workbench", "--try", "--no-browser"]
    command += ["--port", "0", "--session", str(session), *more]
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


def learned(page: Any, address: str) -> None:
    """Open a workbench, and learn a model of its recordings."""
    page.goto(address)
    page.wait_for_selector("article .joints >> nth=2", timeout=LONG)
    idle(page)
    page.get_by_role("button", name="Learn a model").click()
    page.get_by_role("button", name="See where it fails").wait_for(timeout=LONG)
    idle(page)


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
    page.goto(address + "#investigate")
    page.get_by_label("Minutes of motion").fill("2")
    click("Investigate")
    page.get_by_role("heading", name="In the end").wait_for(timeout=5 * LONG)
    idle(page)
    picture("investigate")


def unlisted(page: Any, address: str, name: str) -> None:
    """Take what no effect fits in as a curve, and have formulas proposed, with pictures."""
    learned(page, address)
    page.goto(address + "#diagnose")
    page.locator("#view").get_by_role("button", name="Find what is missing").click()
    left = page.locator("article", has_text="Unexplained on")
    left.wait_for(timeout=LONG)
    idle(page)
    left.scroll_into_view_if_needed()
    page.screenshot(path=PICTURES / f"workbench_unlisted{name}.png")
    left.get_by_role("button", name="Propose formulas").click()
    formula = page.locator("article", has_text="A formula for").first
    formula.wait_for(timeout=5 * LONG)
    idle(page)
    page.locator("section", has_text="Formulas for").evaluate("one => one.scrollIntoView()")
    page.screenshot(path=PICTURES / f"workbench_formulas{name}.png")


def live(page: Any, address: str, name: str, session: Path) -> None:
    """Learn a model, move the simulated arm after a confirmation, with pictures."""
    from lagrangian_ff.arm import exciting_trajectory, write_trajectory

    learned(page, address)
    (session / "motions").mkdir()
    path = session / "motions" / "all_joints.csv"
    write_trajectory(path, exciting_trajectory(4, seed=7, duration=20.0))
    page.goto(address + "#live")
    page.get_by_role("button", name="Send…").click(timeout=LONG)
    page.get_by_role("dialog").wait_for()
    page.wait_for_timeout(300)
    page.screenshot(path=PICTURES / f"workbench_send{name}.png")
    page.get_by_role("button", name="Send", exact=True).click()
    page.get_by_role("button", name="Start recording").click()
    page.get_by_role("button", name="Stop the motion").wait_for()
    page.wait_for_timeout(13_000)
    page.screenshot(path=PICTURES / f"workbench_live{name}.png")
    page.get_by_role("button", name="Stop the motion").wait_for(state="detached", timeout=LONG)
    page.get_by_role("button", name="Stop recording").click()
    page.goto(address + "#investigate")
    idle(page)
    page.locator("#view").get_by_role("button", name="Investigate").click()
    page.get_by_role("dialog").wait_for(timeout=LONG)
    page.wait_for_timeout(300)
    page.screenshot(path=PICTURES / f"workbench_permit{name}.png")


@contextmanager
def simulated_arm() -> Iterator[None]:
    """Run the simulated arm with what the recordings of --try hide, heard on this machine alone."""
    os.environ |= {"ROS_DOMAIN_ID": "97", "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    hidden = "hidden:=['quadratic_drag@joint_2:0.2']"
    command = [sys.executable, "-m", "lagrangian_ff.nodes.arm", "--ros-args", "-p", hidden]
    process = subprocess.Popen(command)
    try:
        yield
    finally:
        process.terminate()
        process.wait()


def main() -> int:
    """Make the pictures and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else "")
    parser.add_argument("--width", type=int, default=1366)
    parser.add_argument("--height", type=int, default=768)
    parser.add_argument("--dark", action="store_true", help="in dark colours")
    parser.add_argument("--live", action="store_true", help="only those of a running arm")
    parser.add_argument("--unlisted", action="store_true", help="only of what nobody listed")
    parser.add_argument("--name", default="", help="added to the pictures' names")
    given = parser.parse_args()
    chromium = shutil.which("chromium")
    if chromium is None:
        raise SystemExit("there is no Chromium: apt install chromium")
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        if given.live:
            stack.enter_context(simulated_arm())
        session = Path(folder) / "session"
        more = ["--live"] if given.live else ["--seed", "5"] if given.unlisted else []
        process, address = started(session, *more)
        try:
            with sync_playwright() as driver:
                browser = driver.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
                page = browser.new_page(
                    viewport={"width": given.width, "height": given.height},
                    color_scheme="dark" if given.dark else "light",
                )
                if given.live:
                    live(page, address, given.name, session)
                elif given.unlisted:
                    unlisted(page, address, given.name)
                else:
                    walk(page, address, given.name)
                browser.close()
        finally:
            process.terminate()
            process.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())
