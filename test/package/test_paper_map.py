"""The map of the paper names nothing that is not there, and leaves no equation out."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

from lagrangian_ff.studies.catalogue import STUDIES

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "paper.md"
TEXT = PAGE.read_text(encoding="utf-8")

LINK = re.compile(r"\[([^\]]+)\]\(([^)#\s]*)(?:#([^)\s]+))?\)")
LINKS = sorted(set(LINK.findall(TEXT)))
CODE = [(text.strip("`"), target) for text, target, _ in LINKS if text.startswith("`")]
PLAIN = set(re.findall(r"`([^`\n]+)`", LINK.sub("", TEXT)))
"""What is set as code and is no link."""

EQUATIONS = [
    *(f"({n})" for n in range(1, 55)),
    *(f"(A.{n})" for n in range(1, 5)),
    *(f"(B.{n})" for n in range(1, 8)),
    *(f"Definition {n}" for n in range(1, 3)),
    *(f"Proposition {n}" for n in range(1, 6)),
    *(f"Theorem {n}" for n in range(1, 3)),
    "Corollary 1",
    *(f"Fig. {n}" for n in range(1, 8)),
]


def names_in(text: str) -> set[str]:
    """Return what a module defines: its own names, and `Class.name` with those of its bases."""
    found: dict[str, set[str]] = {}
    bases: dict[str, list[str]] = {}
    for node in ast.parse(text).body:
        for name in defined(node):
            inside = node.body if isinstance(node, ast.ClassDef) else []
            found[name] = {inner for part in inside for inner in defined(part)}
            above = node.bases if isinstance(node, ast.ClassDef) else []
            bases[name] = [base.id for base in above if isinstance(base, ast.Name)]

    def members(name: str) -> set[str]:
        return found.get(name, set()).union(*map(members, bases.get(name, [])))

    return {*found, *(f"{name}.{inner}" for name in found for inner in members(name))}


def defined(node: ast.stmt) -> list[str]:
    """Return the names that a statement defines."""
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return [node.name]
    targets = node.targets if isinstance(node, ast.Assign) else []
    if isinstance(node, ast.AnnAssign):
        targets = [node.target]
    return [target.id for target in targets if isinstance(target, ast.Name)]


@cache
def names_of(file: Path) -> set[str]:
    """Return what a file defines, and its own name."""
    text = file.read_text(encoding="utf-8")
    found = (
        set(re.findall(r"^EXPORT .*?(\w+)\(", text, re.M))
        if file.suffix == ".c"
        else names_in(text)
    )
    return {file.name} | found


def numbers(label: str) -> list[str]:
    """Return the equations that the first column of a row is about: `(1)-(3)` is three."""
    first = re.findall(r"\(([AB]\.)?(\d+)\)", label)
    if re.fullmatch(r"\(\S+\)-\(\S+\)", label):
        (part, low), (_, high) = first
        return [f"({part}{n})" for n in range(int(low), int(high) + 1)]
    return [f"({part}{n})" for part, n in first] or [label]


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


def place(target: str) -> Path:
    """Return where a link of the page leads."""
    return (PAGE.parent / target).resolve() if target else PAGE


def test_every_link_leads_somewhere() -> None:
    assert [target for _, target, _ in LINKS if not place(target).exists()] == []
    within = [(place(target), anchor) for _, target, anchor in LINKS if anchor]
    assert [(file.name, anchor) for file, anchor in within if anchor not in anchors(file)] == []


def test_every_name_is_in_the_file_it_links_to() -> None:
    assert len(CODE) > 100
    assert [(name, to) for name, to in CODE if name not in names_of(place(to))] == []


def test_no_file_function_or_test_is_named_without_a_link() -> None:
    like_code = re.compile(r"test_\w+|\w+\(.*|[\w./]+\.\w+|[\w.]+/.*")
    assert not {word for word in PLAIN if like_code.fullmatch(word)}


def test_every_equation_is_in_one_row() -> None:
    upto = TEXT.index("## How section IV measures")
    rows = re.findall(r"^\| ([^|]+?) \|", TEXT[:upto], re.MULTILINE)
    told = [number for label in rows for number in numbers(label)]
    assert {each: told.count(each) for each in EQUATIONS} == dict.fromkeys(EQUATIONS, 1)


def test_every_study_is_named() -> None:
    assert {name for name in STUDIES if f"`{name}`" not in TEXT} == set()
    named = set(re.findall(r"stud(?:y|ies) `(\w+)`", TEXT))
    assert named <= set(STUDIES)


def test_every_option_is_one_of_the_commands() -> None:
    sources = (ROOT / "lagrangian_ff" / "cli").rglob("*.py")
    known = set().union(*(re.findall(r'"(--[\w-]+)"', file.read_text()) for file in sources))
    assert {word.split()[0] for word in PLAIN if word.startswith("--")} <= known


def test_the_readme_leads_to_the_map() -> None:
    assert "(docs/paper.md)" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_names_are_seen_as_they_are_defined() -> None:
    text = """
LOW, HIGH = 1, 2
COUNT: int = 3
class A:
    size: int
    def area(self): ...
class B(A):
    def edge(self):
        inner = 1
def f(): ...
"""
    found = {"COUNT", "A", "A.size", "A.area", "B", "B.size", "B.area", "B.edge", "f"}
    assert names_in(text) == found
    assert numbers("(7), (8)") == ["(7)", "(8)"]
    assert numbers("(A.1)-(A.3)") == ["(A.1)", "(A.2)", "(A.3)"]
