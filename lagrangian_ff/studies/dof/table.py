"""The numbers of a study as lines of text."""

from collections.abc import Sequence

from lagrangian_ff.studies.common.study import Numbers
from lagrangian_ff.studies.dof.numbers import Finding


def table_of(numbers: Numbers) -> list[str]:
    """Mean errors by model and number of joints, and what is found; see `numbers_of`."""
    models = numbers["models"]
    joints = sorted({n for rows in models.values() for n in rows}, key=int)
    text = [f"{numbers['cases']} cases", ""]
    text += ["mean error of torque, of the largest one in training, by the number of joints:"]
    text += [_row(["", *joints])]
    for model, rows in models.items():
        text += [_row([model, *(f"{rows[n]['mean']:.1e}" if n in rows else "-" for n in joints)])]
    counts = sorted({row["count"] for rows in models.values() for row in rows.values()})
    if counts:
        robots = str(counts[0]) if len(counts) == 1 else f"{counts[0]} to {counts[-1]}"
        text += ["", f"each the mean over {robots} robot{'' if counts[-1] == 1 else 's'}"]
    if numbers["findings"]:
        text += ["", "what is claimed, and the numbers of joints at which it holds:"]
        text += [_finding(finding) for finding in numbers["findings"]]
    if numbers["failed"]:
        text += ["", "failed:", *(f"  {case}: {why}" for case, why in numbers["failed"].items())]
    return text


def _finding(finding: Finding) -> str:
    rows = finding["joints"]
    holds = [n for n, row in rows.items() if row["holds"]]
    fails = [n for n, row in rows.items() if not row["holds"]]
    said = f"at {', '.join(holds)}" if holds else "nowhere"
    return f"  {finding['claim']}: {said}" + (f"; not at {', '.join(fails)}" if fails else "")


def _row(cells: Sequence[str]) -> str:
    return ("  " + f"{cells[0]:<16}" + "".join(f"{cell:>9}" for cell in cells[1:])).rstrip()
