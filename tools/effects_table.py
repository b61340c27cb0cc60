"""Write the table of effects in docs/effects.md from the list of effects.

python tools/effects_table.py            writes it
python tools/effects_table.py --check    fails where it differs from the list
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from lagrangian_ff.effects import EFFECTS, Effect
from lagrangian_ff.effects.user import trial_motion

PAGE = Path(__file__).resolve().parents[1] / "docs" / "effects.md"
TABLE = re.compile(r"^\| effect \|.*?(?=\n\n)", re.MULTILINE | re.DOTALL)


def main(check: bool) -> int:
    """Write the table, or return 1 where it is not that of the list."""
    before = PAGE.read_text()
    after = TABLE.sub(lambda _: table(), before, count=1)
    if check and after != before:
        print("docs/effects.md is stale: python tools/effects_table.py writes its table")
        return 1
    if not check:
        PAGE.write_text(after)
    return 0


def table() -> str:
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


if __name__ == "__main__":
    sys.exit(main("--check" in sys.argv[1:]))
