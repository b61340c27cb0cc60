"""Showing the findings: in the terminal, as pictures, on the page and as JSON."""

import json
from dataclasses import asdict
from typing import Any

from rich.console import Console
from rich.table import Table

from lagrangian_ff import __version__, arm
from lagrangian_ff.demo.findings import LABELS, NAMES, TARGETS, Findings
from lagrangian_ff.demo.folder import Folder
from lagrangian_ff.demo.page import write_demo_page
from lagrangian_ff.report.figures import (
    torque_figure,
    tracking_bars_figure,
    tracking_time_figure,
)
from lagrangian_ff.report.numbers import mrad, number, percent
from lagrangian_ff.report.style import png


def write_results(findings: Findings, folder: Folder) -> None:
    """Pictures, page and JSON."""
    compared = findings.comparison
    assert compared is not None
    arm.picture(folder.picture("arm"))
    pictures = {
        "torque": torque_figure(compared.motion, compared.predicted, compared.interval),
        "tracking_bars": tracking_bars_figure(
            {f"on {NAMES[name]}": findings.runs(name) for name in NAMES}
        ),
        **{f"tracking_{name}": tracking_time_figure(findings.runs(name)) for name in NAMES},
    }
    drawn = {name: png(figure) for name, figure in pictures.items()}
    for name, data in drawn.items():
        folder.picture(name).write_bytes(data)
    drawn["arm"] = folder.picture("arm").read_bytes()
    write_demo_page(findings, drawn, folder.page)
    text = json.dumps(record_of(findings), indent=2, ensure_ascii=False) + "\n"
    folder.record.write_text(text, encoding="utf-8")


def record_of(findings: Findings) -> dict[str, Any]:
    """Everything the page shows, for JSON; angles in rad, torques in N·m, memory in bytes."""
    assert findings.comparison is not None
    options = {**asdict(findings.options), "output": str(findings.options.output)}
    return {
        "version": __version__,
        "options": options,
        "reached": findings.good,
        "tracking": {
            name: {
                "runs": {
                    run: {**found[run].record(), "clock_speed": findings.speed[name].get(run)}
                    for run in LABELS
                },
                "ratio": findings.ratio(name),
                "ratio_without_friction": findings.ratio(name, "without_friction"),
                "ratio_bound": findings.ratio(name, "bound"),
                "target": TARGETS[name],
                "reached": findings.reached(name),
                "ordered": findings.ordered(name),
            }
            for name, found in findings.tracking.items()
        },
        "torque": findings.comparison.record(),
        "identification": findings.identification,
        "seconds": {name: round(took, 2) for name, took in findings.seconds.items()},
        "memory": findings.memory,
        "stream": findings.stream,
        "clock_speed": findings.clock,
        "processors_of_others": findings.others,
        "busy": findings.busy,
    }


def print_findings(findings: Findings, folder: Folder, console: Console) -> None:
    """Tables and verdict."""
    console.print()
    console.print(_torque_table(findings))
    for name in NAMES:
        console.print(_tracking_table(findings, name))
    for name in NAMES:
        console.print(_verdict(findings, name), highlight=False)
    if findings.busy:
        console.print(f"[yellow]note:[/] {findings.busy}", highlight=False)
    console.print(f"\nLook at it: [bold]{folder.page}[/]", highlight=False, soft_wrap=True)
    console.print(
        f"Model {folder.model}, recordings {folder.bag()} and {folder.unseen}, all numbers "
        f"{folder.record}",
        highlight=False,
        soft_wrap=True,
    )


def _torque_table(findings: Findings) -> Table:
    assert findings.comparison is not None
    score, spread = findings.comparison.score, findings.comparison.motion.tau.std(axis=0)
    table = Table(
        title=f"Torque predicted by {findings.options.model} on {NAMES['unseen']}",
        title_justify="left",
    )
    for column in ("joint", "spread [N·m]", "RMS error [N·m]", "error / spread", "nMSE"):
        table.add_column(column, justify="left" if column == "joint" else "right")
    for n, joint in enumerate(score.joints):
        table.add_row(
            joint,
            number(float(spread[n])),
            number(float(score.rmse[n])),
            percent(float(score.rmse[n] / spread[n])),
            number(float(score.nmse[n])),
        )
    return table


def _tracking_table(findings: Findings, name: str) -> Table:
    runs = findings.runs(name)
    table = Table(
        title=f"RMS tracking error in mrad on {NAMES[name]}", title_justify="left", show_footer=True
    )
    table.add_column("joint", footer="all joints\nratio")
    for run, tracking in zip(LABELS, runs, strict=True):
        table.add_column(
            LABELS[run],
            footer=f"{mrad(tracking.total)}\n{findings.ratio(name, run):.3f}",
            justify="right",
        )
    for n, joint in enumerate(runs[0].joints):
        table.add_row(joint, *(mrad(float(tracking.rms[n])) for tracking in runs))
    return table


def _verdict(findings: Findings, name: str) -> str:
    ratio, target = findings.ratio(name), TARGETS[name]
    order = "none > without friction > with friction"
    reached = "[green]✓[/]" if findings.reached(name) else "[red]✗[/]"
    ordered = "[green]✓[/]" if findings.ordered(name) else "[red]✗[/]"
    return (
        f"{reached} on {NAMES[name]} the error falls to {percent(ratio)} (target: at most "
        f"{percent(target)})   {ordered} {order}"
    )
