"""The numbers of a study as lines of text."""

from collections.abc import Sequence

from lagrangian_ff.studies.common.findings import told
from lagrangian_ff.studies.common.study import Numbers, failures_told


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
    text += told(numbers["findings"])
    text += failures_told(numbers["failed"])
    return text


def _row(cells: Sequence[str]) -> str:
    return ("  " + f"{cells[0]:<16}" + "".join(f"{cell:>9}" for cell in cells[1:])).rstrip()
