"""Every command that the documentation shows is one of the program, and prints what is shown."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy")
pytest.importorskip("pybullet")

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import doc_commands  # noqa: E402
from doc_commands import PAGES, Session, Shown, UnsoundError, agreed, blocks, inline  # noqa: E402

RUN = [
    page
    for page in PAGES
    if any(not b.reason and b.language in ("bash", "console", "python") for b in blocks(page))
]


def name(page: Path) -> str:
    return page.name


@pytest.mark.parametrize("page", RUN, ids=name)
def test_commands_of_a_page_run_and_print_what_is_shown(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    session = Session(page, tmp_path, reduced=True)
    session.run()
    assert session.ran > 0


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_commands_of_a_page_are_those_of_the_program(page: Path) -> None:
    for block in blocks(page):
        assert block.language, f"{block.where}: what is this a block of?"
        for shown in block.commands():
            doc_commands.parse(shown.words)
    for text in inline(page):
        doc_commands.parse_inline(text)


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_what_is_not_run_says_why(page: Path) -> None:
    for block in blocks(page):
        tests = re.findall(r"\btest/[\w/.]+", block.reason)
        assert [test for test in tests if not (ROOT / test).exists()] == [], block.where


@pytest.mark.parametrize(
    "command",
    [
        "lagrangian_ff compare model.npz",
        "lagrangian_ff identify slow --no-such-option",
        "ros2 run lagrangian_ff monitor --ros-args -p no_such_parameter:=1",
        "ros2 param set /identify no_such_parameter 1",
        "ros2 service call /identify/no_such_service std_srvs/srv/Trigger",
        "ros2 launch lagrangian_ff record.launch.py no_such_argument:=1",
        "make no-such-target",
    ],
)
def test_what_the_program_lacks_is_found(command: str) -> None:
    with pytest.raises(UnsoundError):
        doc_commands.parse(command.split())


def test_output_is_compared_by_words_and_written_with_its_numbers() -> None:
    shown = Shown("one", ["error 0.5 N·m", "...", "saved: a"])
    assert agreed(shown, ["error 0.25", "N·m", "more", "saved: a"], "") == [
        "error 0.25", "N·m", "...", "saved: a",
    ]  # fmt: skip
    with pytest.raises(UnsoundError):
        agreed(shown, ["error 0.25 N·m", "saved: b"], "")
    with pytest.raises(UnsoundError):
        agreed(shown, ["saved: a", "error 0.25 N·m"], "")


def test_a_number_that_is_part_of_a_name_is_compared() -> None:
    shown = Shown("one", ["joint_3  0.5"])
    assert agreed(shown, ["joint_1  0.1", "joint_3  0.25"], "") == ["joint_3  0.25"]
