"""The site builds without a warning, and links lead somewhere on GitHub, too."""

from __future__ import annotations

import re
import subprocess
import sys
from functools import cache
from pathlib import Path
from urllib.parse import unquote

import pytest

pytest.importorskip("pybullet", reason="the pages of the nodes are made with the simulated arm")

ROOT = Path(__file__).resolve().parents[2]
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
LINK = re.compile(r"(?:\]\(|src=\"|srcset=\")(?!https?:)([^)\s\"#]*)(?:#([^)\s\"]+))?[)\"]")

LOCAL = re.compile(r'(?:href|src)="(?!https?:|mailto:|data:)([^"#?]*)(?:\?[^"#]*)?(?:#([^"]+))?"')


def anchors(page: Path) -> set[str]:
    """Return the anchors that GitHub gives the headings of a page."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


@cache
def identifiers(page: Path) -> set[str]:
    """Return what a page of the site can be entered at."""
    return set(re.findall(r'\bid="([^"]+)"', page.read_text(encoding="utf-8")))


def leads_somewhere(page: Path, target: str, anchor: str) -> bool:
    """Return whether a link of a page of the site finds its file, and the place in it."""
    file = (page.parent / target).resolve() if target else page
    return file.exists() and (not anchor or file.suffix != ".html" or anchor in identifiers(file))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_of_a_page_lead_somewhere(page: Path) -> None:
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    for target, anchor in LINK.findall(text):
        file = (page.parent / target).resolve() if target else page
        assert file.exists(), target
        if anchor and file.suffix == ".md":
            assert anchor in anchors(file), f"{target}#{anchor}"


def test_readme_is_short() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 160


def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    for needed in ("sphinx", "myst_parser", "furo", "rclpy"):
        pytest.importorskip(needed)
    strict = "-q", "-W", "--keep-going", "-n", "-d", str(tmp_path / "read")
    command = [sys.executable, "-m", "sphinx", *strict, str(ROOT / "docs"), str(tmp_path / "site")]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    commands = (tmp_path / "site" / "reference" / "commands" / "diagnose.html").read_text()
    assert "--confirm" in commands
    assert "fade_time" in (tmp_path / "site" / "reference" / "nodes" / "watchdog.html").read_text()
    assert "1.0.0" in (tmp_path / "site" / "changelog.html").read_text()
    broken = [
        f"{page.name}: {target}#{anchor}"
        for page in (tmp_path / "site").rglob("*.html")
        for target, anchor in LOCAL.findall(page.read_text(encoding="utf-8"))
        if not leads_somewhere(page, unquote(target), unquote(anchor))
    ]
    assert broken == []
