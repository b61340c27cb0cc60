"""The page of the demo, its pictures and its JSON."""

import json
from collections.abc import Mapping
from pathlib import Path

from lagrangian_ff import __version__, arm
from lagrangian_ff.arm import ArmParameters
from lagrangian_ff.demo.findings import NAMES, TARGETS, Findings
from lagrangian_ff.demo.folder import Folder
from lagrangian_ff.numbers import mrad, percent, typeset
from lagrangian_ff.report import Section, html, write_page
from lagrangian_ff.report.sections.effects import effects_section
from lagrangian_ff.report.sections.torque import torque_figure, torque_section
from lagrangian_ff.report.sections.tracking import (
    tracking_bars_figure,
    tracking_section,
    tracking_time_figure,
)
from lagrangian_ff.report.style import png

Pictures = Mapping[str, bytes]
THROUGH = {
    "stream": "500 commands a second while it moved",
    "trajectory": "with the points of the trajectory",
}


def write_results(findings: Findings, folder: Folder) -> None:
    """Write pictures, page and JSON."""
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
    text = json.dumps(findings.record(), indent=2, ensure_ascii=False) + "\n"
    folder.record.write_text(text, encoding="utf-8")


def write_demo_page(findings: Findings, pictures: Pictures, path: Path) -> None:
    """Write the page.

    Args:
        pictures: PNG files by name: arm, tracking_bars, tracking_training, tracking_unseen,
            torque.
    """
    sections = [make(findings, pictures) for make in SECTIONS]
    title = (
        f"The learned feedforward leaves {percent(findings.ratio('training'))} of the tracking "
        f"error on the motion it learned from, and {percent(findings.ratio('unseen'))} on one it "
        "never saw"
    )
    summary = (
        "A simulated six-joint arm moved, its joint states were recorded over ROS 2, and a model "
        "of its torques was learned from nothing but these: no robot description, no equations of "
        "the arm. The torque the model computes for a motion is then added to the arm's position "
        "controller, and the arm follows the motion better."
    )
    footer = f"lagrangian_ff {__version__}, made by lagrangian_ff demo"
    write_page(path, title, sections, summary=summary, footer=footer)


def _verdict(findings: Findings, pictures: Pictures) -> Section:
    ordered = all(findings.ordered(name) for name in NAMES)
    order = html.Card(
        "each part helps" if ordered else "not every part helps",
        "error: no feedforward > without friction > with friction",
        "the paper's three groups in their order, on both motions",
        ordered,
    )
    cards = [*(_ratio_card(findings, name) for name in NAMES), order]
    bars = html.figure(
        pictures["tracking_bars"],
        "bars of the RMS tracking error of each joint for the four runs on both motions",
        "RMS of reference position less measured position. The bound is the same arm, simulated "
        "beside, fed with its own true torques, which only a simulator knows; what is left "
        "then is friction at rest, encoders and the controller.",
    )
    busy = html.note(findings.busy.capitalize() + ".") if findings.busy else ""
    return Section("Does it work?", "", html.cards(cards) + bars + busy)


def _ratio_card(findings: Findings, name: str) -> html.Card:
    runs = findings.tracking[name]
    return html.Card(
        percent(findings.ratio(name)),
        f"of the tracking error is left on {NAMES[name]}",
        f"{mrad(runs['none'].total)} → {mrad(runs['all'].total)} mrad; target: at most "
        f"{percent(TARGETS[name])}",
        findings.reached(name),
    )


def _story(findings: Findings, pictures: Pictures) -> Section:
    options, found = findings.options, findings.identification
    begin = f"the first {percent(options.train)} of it, the rest held out"
    learned = "all of it" if options.train == 1.0 else begin
    steps = html.steps(
        [
            f"The arm moved for {options.duration:.0f} s through its workspace under its position "
            "controller alone. The node identify recorded joint_states at 500 Hz to a bag: "
            "position, velocity, and the effort its current sensors saw.",
            f"identify learned {options.model} from {learned}: {found.samples} samples, "
            f"{found.seconds:.0f} s of computing."
            + (
                f" It chose {found.model}: chain is a kernel on the Lagrangian of a serial "
                "arm, pushed through the Euler-Lagrange equations; fri is viscous and Coulomb "
                "friction with an offset."
                if options.model == "auto+fri"
                else ""
            ),
            "The node feedforward loaded the model. For each motion it computed the torques and "
            f"sent them to the arm ({THROUGH[options.through]}), first without the friction part, "
            "then with it.",
            "The same was done on a motion the model never saw, made from another seed.",
        ]
    )
    picture = html.figure(pictures["arm"], "the simulated six-joint arm")
    return Section(
        "What happened",
        "Three ROS 2 nodes, each a separate process, talked over DDS as they would with a real "
        "robot; only the arm is simulated (PyBullet, geared motors, friction, noisy sensors).",
        html.beside(steps, picture),
    )


def _unseen(findings: Findings, pictures: Pictures) -> Section:
    lead = "What counts in use: the model must get right what it was not shown."
    title, picture = "Tracking a motion the model never saw", pictures["tracking_unseen"]
    return tracking_section(findings.runs("unseen"), picture, title, lead, strong=2)


def _training(findings: Findings, pictures: Pictures) -> Section:
    lead = (
        "A motion that is repeated, as in production. The run without feedforward is the one that "
        "was recorded."
    )
    title, picture = "Tracking the motion it learned from", pictures["tracking_training"]
    return tracking_section(findings.runs("training"), picture, title, lead, strong=2)


def _torque(findings: Findings, pictures: Pictures) -> Section:
    assert findings.comparison is not None
    return torque_section(
        findings.comparison,
        pictures["torque"],
        "Torque: measured and predicted",
        "Judged on the whole motion the model never saw, recorded while no feedforward was sent. "
        "Nothing of it was used in learning.",
    )


def _effects(findings: Findings, pictures: Pictures) -> Section:
    true = ArmParameters()
    return effects_section(
        findings.identification.effects,
        truth={
            ("viscous", "B"): true.viscous,
            ("coulomb", "F_c"): true.coulomb,
            ("offset", "c"): (0.0,) * len(true.viscous),
        },
        remark="The true values are those of the simulated arm; identification did not know them. "
        "A universal kernel can take over part of an effect, so that values drift from the truth "
        "although the torque is right.",
    )


def _numbers(findings: Findings, pictures: Pictures) -> Section:
    chosen = findings.identification.hyperparameters
    tables = (
        ("option", _options(findings)),
        ("chosen by identify", {n: ", ".join(map(typeset, v)) for n, v in chosen.items()}),
        ("stage [s]", {n: f"{took:.1f}" for n, took in findings.seconds.items()}),
        ("most memory held [MB]", {n: f"{size / 1e6:.0f}" for n, size in findings.memory.items()}),
    )
    pieces = [
        html.table([name, ""], [[k, str(v)] for k, v in rows.items()]) for name, rows in tables
    ]
    small = html.note(
        f"The arm's clock, on /clock, went at {findings.clock:.2f} times real time. It waits for "
        "the torque of every tick, so that the figures do not depend on the machine."
    )
    return Section(
        "How it was made",
        "What is needed to make it again. These and all other numbers are in demo.json.",
        html.columns(pieces) + small,
    )


def _options(findings: Findings) -> dict[str, str]:
    options = findings.options
    return {
        "speed": str(options.speed),
        "seed": str(options.seed),
        "duration": f"{options.duration:g} s",
        "unseen duration": f"{options.unseen_duration:g} s",
        "model": options.model,
        "samples": str(options.samples),
        "clock speed": f"{options.clock_speed:g}",
        "train": f"{options.train:g}",
        "through": options.through,
    }


SECTIONS = (_verdict, _story, _unseen, _training, _torque, _effects, _numbers)
"""The page from top to bottom."""
