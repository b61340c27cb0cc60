"""Write the tables of the documentation that follow from lists in the sources.

python tools/doc_tables.py            writes them
python tools/doc_tables.py --check    fails where one differs from its list
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path

from lagrangian_ff.effects import EFFECTS, Effect
from lagrangian_ff.effects.user import trial_motion

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "test" / "nodes"))
from fault_rows import table as faults  # noqa: E402


def effects() -> str:
    """Return the table of all effects in Markdown."""
    lines = ["| effect | torque | shows as | above zero |", "|---|---|---|---|"]
    for effect in EFFECTS.values():
        formula = effect.formula.replace("|", r"\|")
        lines.append(f"| `{effect.name}` | `{formula}` | {effect.shows_as} | {_signs(effect)} |")
    return "\n".join(lines)


def _signs(effect: Effect) -> str:
    """Return what nature has above zero of an effect."""
    shape = {shape.name: shape.start for shape in effect.shapes}
    words = [words.partition(" in ")[0] for words in effect.signs(trial_motion(), 1, shape)]
    return ", ".join([*words, *(["all friction"] if effect.part == "friction" else [])])


# By page: the first column of the table's heading, and the table.
TABLES: dict[str, tuple[str, Callable[[], str]]] = {
    "effects.md": ("effect", effects),
    "feedforward.md": ("what", faults),
}


def main(check: bool) -> int:
    """Write the tables, or return 1 where one is not that of its list."""
    stale = []
    for name, (heading, table) in TABLES.items():
        page = ROOT / "docs" / name
        before = page.read_text()
        pattern = re.compile(rf"^\| {heading} \|.*?(?=\n\n)", re.MULTILINE | re.DOTALL)
        (old,) = pattern.findall(before)
        new = table()
        if new == old:
            continue
        stale.append(f"docs/{name}")
        if not check:
            page.write_text(before.replace(old, new))
    if check and stale:
        print(f"stale: {', '.join(stale)}; python tools/doc_tables.py writes their tables")
    return 1 if check and stale else 0


if __name__ == "__main__":
    sys.exit(main("--check" in sys.argv[1:]))
