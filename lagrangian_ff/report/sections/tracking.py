"""How far the robot was from its reference, run beside run."""

from collections.abc import Sequence

from lagrangian_ff.report import html
from lagrangian_ff.report.numbers import mrad
from lagrangian_ff.report.section import Section
from lagrangian_ff.report.tracking import Tracking


def tracking_section(
    runs: Sequence[Tracking],
    picture: bytes,
    title: str,
    lead: str,
    *,
    strong: int | None = None,
) -> Section:
    """Table and figure of the runs along one trajectory.

    Args:
        runs: of the same trajectory; the first is what the others are compared with.
        picture: PNG of `tracking_time_figure`.
        title: of the section.
        lead: which trajectory it is.
        strong: the run that matters most.
    """
    first = runs[0]
    rows = [
        [joint, *(mrad(float(run.rms[n])) for run in runs)] for n, joint in enumerate(first.joints)
    ]
    rows.append(["all joints", *(mrad(run.total) for run in runs)])
    header = ["RMS error [mrad]", *(run.label for run in runs)]
    shares = html.note(
        "All joints, relative to the first column: "
        + ", ".join(f"{run.label} {run.total / first.total:.3g}" for run in runs[1:])
        + "."
    )
    shown = html.figure(
        picture,
        "tracking error of each joint over time for each run",
        "Reference position less measured position. The numbers over each plot are RMS errors, in "
        "the order of the legend.",
    )
    column = None if strong is None else strong + 1
    body = html.table(header, rows, strong=column, total=True) + shares + shown
    return Section(title, lead, body)
