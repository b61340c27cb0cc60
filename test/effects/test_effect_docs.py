"""The page on effects says what the effects themselves say."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from lagrangian_ff.effects import EFFECTS, load_effects


@pytest.fixture
def page(root: Path) -> str:
    """Return the page's text."""
    return (root / "docs" / "effects.md").read_text()


def test_tables_are_those_of_their_lists(root: Path) -> None:
    tool = root / "tools" / "doc_tables.py"
    command = [sys.executable, str(tool), "--check"]
    here = {**os.environ, "PYTHONPATH": str(root)}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=here)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_table_holds_every_effect_as_it_is(page: str) -> None:
    rows = re.findall(r"^\| `(\w+)` \| `(.+?)` \| (.+?) \| (.*) \|$", page, re.MULTILINE)
    said = {name: (formula.replace("\\|", "|"), shows) for name, formula, shows, _ in rows}
    assert said == {name: (e.formula, e.shows_as) for name, e in EFFECTS.items()}


@pytest.mark.usefixtures("catalogue_kept")
def test_the_example_works(root: Path, tmp_path: Path) -> None:
    page = (root / "docs" / "own_effect.md").read_text()
    example = re.search(r"```python\n(.*?)```", page, re.DOTALL)
    assert example
    file = tmp_path / "mine.py"
    file.write_text(example.group(1))
    (pit,) = load_effects(file)
    assert pit.name == "pit"
