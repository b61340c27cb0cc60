"""Write the table of faults in docs/feedforward.md from the list that the test injects.

python tools/fault_table.py            writes it
python tools/fault_table.py --check    fails where it differs from the list
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "test" / "nodes"))
from fault_rows import table  # noqa: E402

PAGE = ROOT / "docs" / "feedforward.md"
TABLE = re.compile(r"^\| what \|.*?(?=\n\n)", re.MULTILINE | re.DOTALL)


def main(check: bool) -> int:
    """Write the table, or return 1 where it is not that of the list."""
    before = PAGE.read_text()
    after = TABLE.sub(lambda _: table(), before, count=1)
    if check and after != before:
        print("docs/feedforward.md is stale: python tools/fault_table.py writes its table")
        return 1
    if not check:
        PAGE.write_text(after)
    return 0


if __name__ == "__main__":
    sys.exit(main("--check" in sys.argv[1:]))
