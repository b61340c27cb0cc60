"""In a real browser: what a recording could show, remedies that are buttons, a chosen model."""

import json
from collections.abc import Callable
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
    uploaded,
    violations,
)
from workbench_examples import Served, moved, serving

from lagrangian_ff.identification import Model

playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
pytestmark = needs_chromium
serve = pytest.fixture(serving)
browser = pytest.fixture(scope="module")(chromium)
page = pytest.fixture(opened)

Serve = Callable[..., Served]
LATE = 0.009  # s
ARM = """<robot name="arm"><link name="base"/><link name="x"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="y"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="a" type="revolute"><parent link="base"/><child link="x"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="9" velocity="9"/></joint>
<joint name="b" type="revolute"><parent link="x"/><child link="y"/><axis xyz="0 1 0"/>
<origin xyz="0.5 0 0"/><limit lower="-3" upper="3" effort="9" velocity="9"/></joint></robot>"""


def saved(served: Served) -> dict[str, Any]:
    """Return the session on disk."""
    found: dict[str, Any] = json.loads((served.session / "session.json").read_text())
    return found


def test_a_card_shows_what_its_recording_could_show(
    page: Any, browser: Any, tmp_path: Path, serve: Serve
) -> None:
    served = serve(tmp_path / "session", moved(tmp_path / "motion.npz", 0))
    shown(page, served)
    summary = page.get_by_text("At 10 % of the torque it shows")
    summary.wait_for(timeout=LONG)
    found = saved(served)["cards"][0]["observed"]
    seen = [row for row in found["least"].values() if all(row[j] <= 0.1 for j in row if row[j])]
    assert 0 < len(seen) <= len(found["least"])
    summary.click()
    row = page.locator(".seen tbody tr", has_text="stribeck").first
    assert row.locator("td").count() == 2
    title = row.locator("td").first.get_attribute("title")
    assert "stribeck: seen on a from" in title
    page.get_by_role("combobox", name="use of motion.npz").select_option("search")
    playwright.expect(page.locator(".seen")).to_be_visible()  # it stays open
    for scheme in ("light", "dark"):
        for other in opened(browser, bypass_csp=True, color_scheme=scheme):
            shown(other, served)
            other.get_by_text("At 10 % of the torque it shows").click()
            assert not violations(other), scheme
    assert served.stop() == 0


def test_a_recording_that_is_not_looked_at_can_be_used(
    page: Any, tmp_path: Path, serve: Serve
) -> None:
    # They are looked at one after the other: the last one waits long enough to be cancelled.
    sources = [moved(tmp_path / f"motion_{seed}.npz", seed) for seed in range(3)]
    served = serve(tmp_path / "session", *sources)
    page.goto(served.address)
    which = "which effects motion_2.npz could show"
    page.get_by_role("button", name=f"Cancel: {which}").click(timeout=LONG)
    page.get_by_text("is not known: cancelled").wait_for()
    able = page.get_by_role("button", name="Learn a model")
    playwright.expect(able).to_be_enabled(timeout=LONG)
    page.get_by_role("button", name=f"Find out: {which}").click()
    seen = page.get_by_text("At 10 % of the torque it shows")
    playwright.expect(seen).to_have_count(3, timeout=LONG)
    assert served.stop() == 0


def test_a_reversed_effort_is_turned_round_by_a_button(
    page: Any, browser: Any, tmp_path: Path, serve: Serve
) -> None:
    sources = [moved(tmp_path / f"{k}.npz", k, 0.0, 20.0, (1.0, -1.0)) for k in (0, 1)]
    served = serve(tmp_path / "session")
    page.goto(served.address)
    uploaded(page, sources)
    assert page.get_by_text("Mend first").count() == 2
    for other in opened(browser, bypass_csp=True, color_scheme="dark"):
        shown(other, served)
        assert not violations(other)
    page.get_by_role("button", name="Turn the sign of b round").first.click()
    back = page.get_by_role("button", name="Take it back")
    playwright.expect(back).to_have_count(2, timeout=LONG)
    idle(page)
    playwright.expect(page.get_by_text("Mend first")).to_have_count(0)
    assert [card["scale"] for card in saved(served)["cards"]] == [{"b": -1.0}] * 2
    learn(page)
    node = saved(served)["nodes"][0]
    assert all(one["nmse"] < 0.02 for one in node["compared"]["joints"].values())
    conditioning = Model.load(node["file"]).identified.conditioning
    assert conditioning is not None
    assert conditioning.effort_scale == {"b": -1.0}
    page.goto(served.address + "#take")
    commands = page.locator("pre").last.inner_text()
    assert "--effort-scale b=-1 --train 1.0" in commands.splitlines()[0]
    assert "--effort-scale" not in commands.splitlines()[-1]  # the model knows it
    page.goto(served.address + "#data")
    page.get_by_role("button", name="Take it back").first.click()  # of both, as it was done
    idle(page)
    page.get_by_text("The model was learned before").wait_for()
    again = page.get_by_role("button", name="Learn again")
    playwright.expect(again).to_be_enabled(timeout=LONG)  # work may follow work
    assert [card["scale"] for card in saved(served)["cards"]] == [{}] * 2
    assert served.stop() == 0


def test_a_recording_that_disagrees_with_the_model_is_read_in_another_way(
    page: Any, tmp_path: Path, serve: Serve
) -> None:
    sources = [moved(tmp_path / "good.npz", 0), moved(tmp_path / "bad.npz", 1, sign=(0.1, 0.1))]
    served = serve(tmp_path / "session", *sources)
    shown(page, served)
    page.wait_for_selector("article .joints >> nth=1", timeout=LONG)
    idle(page)
    learn(page)
    button = page.get_by_role("button", name="Multiply the effort by")
    assert button.count() == 1
    page.goto(served.address + "#diagnose")
    page.get_by_role("button", name="Find what is missing").last.click()
    idle(page)
    page.get_by_text("Look at this first").wait_for(timeout=LONG)
    page.locator(".check button").first.click()
    idle(page)
    cards = saved(served)["cards"]
    assert cards[0]["scale"] == {}
    assert cards[1]["scale"]["a"] == pytest.approx(10.0, rel=0.1)
    compared = saved(served)["nodes"][0]["compared"]
    assert all(one["nmse"] < 0.05 for one in compared["joints"].values())
    assert saved(served)["nodes"][0]["diagnosed"] is None
    assert served.stop() == 0


def test_effort_that_comes_late_is_read_earlier(page: Any, tmp_path: Path, serve: Serve) -> None:
    sources = [moved(tmp_path / f"{seed}.npz", seed, drag=0.0, late=LATE) for seed in (0, 1)]
    served = serve(tmp_path / "session", *sources)
    shown(page, served)
    page.wait_for_selector("article .joints >> nth=1", timeout=LONG)
    idle(page)
    learn(page)
    page.goto(served.address + "#diagnose")
    page.get_by_role("button", name="Find what is missing").last.click()
    idle(page)
    playwright.expect(page.locator(".check", has_text="of every joint comes")).to_have_count(1)
    page.get_by_role("button", name="Read every effort").click()
    idle(page)
    delay = saved(served)["effort_delay"]
    assert delay == pytest.approx(LATE, rel=0.1)
    page.get_by_text("is read as").wait_for()
    page.goto(served.address + "#data")
    page.get_by_role("button", name="Learn again").click()
    idle(page)
    first, second = saved(served)["nodes"]
    assert second["settings"]["effort_delay"] == delay
    assert all(
        second["compared"]["joints"][joint]["rmse"] < first["compared"]["joints"][joint]["rmse"]
        for joint in "ab"
    )
    page.goto(served.address + "#take")
    assert f"--effort-delay {delay}" in page.locator("pre").last.inner_text()
    page.goto(served.address + "#data")
    page.get_by_role("button", name="Take it back").click()
    page.get_by_text("is read as").wait_for(state="detached")
    assert saved(served)["effort_delay"] == 0.0
    assert served.stop() == 0


def test_a_model_is_chosen_and_remembered(
    page: Any, browser: Any, tmp_path: Path, serve: Serve
) -> None:
    (tmp_path / "arm.urdf").write_text(ARM)
    given = moved(tmp_path / "motion.npz", 0), "--urdf", tmp_path / "arm.urdf"
    served = serve(tmp_path / "session", *given)
    shown(page, served)
    page.goto(served.address + "#model")
    choice = page.get_by_role("combobox", name="model to learn")
    assert choice.input_value() == "auto"
    assert "Bodies of arm.urdf" in choice.inner_text()
    choice.select_option("energy")
    page.get_by_text("parallel arms").wait_for()
    page.reload()
    assert page.get_by_role("combobox", name="model to learn").input_value() == "energy"
    learn(page)
    node = saved(served)["nodes"][-1]
    assert node["described"]["name"] == "energy+fri"
    page.get_by_role("combobox", name="model to learn").select_option("urdf")
    page.get_by_text("Its masses are corrected").wait_for()
    for other in opened(browser, bypass_csp=True):
        other.goto(served.address + "#model")
        other.get_by_role("button", name="See where it fails").wait_for()
        assert not violations(other)
    page.goto(served.address + "#take")
    assert "--model energy+fri" in page.locator("pre").last.inner_text()
    pytest.importorskip("pinocchio", reason="the extra urdf is not installed")
    page.goto(served.address + "#model")
    page.get_by_role("button", name="Learn again").click()
    idle(page)
    node = saved(served)["nodes"][-1]
    assert Model.load(node["file"]).kernel.mechanism is not None
    page.goto(served.address + "#take")
    assert "arm.urdf --train 1.0" in page.locator("pre").last.inner_text()
    assert served.stop() == 0
