"""`predict`: a model held against another recording."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.held import Held
from lagrangian_ff.cli.common.leaving import leaving
from lagrangian_ff.cli.common.options import (
    SOURCE_HELP,
    add_conditioning,
    add_force,
    add_json,
    add_topic,
)
from lagrangian_ff.cli.common.outputs import check_file, write_record, write_table
from lagrangian_ff.cli.common.own_effects import add_effects_file, load_own_effects
from lagrangian_ff.cli.common.progress import progress_bar
from lagrangian_ff.cli.text.errors import LEGEND, covered, error_table, verdict
from lagrangian_ff.errors import UserError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from lagrangian_ff.diagnosis import Comparison
    from lagrangian_ff.identification import Model

    Columns = dict[str, NDArray[np.float64]]

NAME = "predict"
SUMMARY = "compare a model with a recording: error per joint, torques as CSV"
USAGE = "MODEL SOURCE [options]"
DESCRIPTION = """\
Predicts the torque of a recorded motion and compares it with what was measured: the test of a
model on a recording it has not seen. The recording may hold more joints than the model, in any
order; it is made ready as those were that the model was identified from."""
EPILOG = """\
examples:
  lagrangian_ff predict model.npz other_bag
  lagrangian_ff predict model.npz other_bag --output torque.csv --terms --intervals

what comes out:
  the error of each joint in N·m (rmse) and as a share of its torque's variance (nmse; below 0.05
  is good), and how much of the motion lies outside what the model was identified on;
  with --output a CSV: time, measured/<joint>, predicted/<joint>, and with --terms the parts of
  the predicted torque: gravity/, inertia/, coriolis/ and every effect, such as coulomb/<joint>;
  with --intervals how sure the model is: low/<joint> and high/<joint>, between which 90 % of the
  measured torques should lie, in the CSV, and the share that does by joint (covered in --json)."""


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("model", type=Path, metavar="MODEL", help="a model file of identify")
    parser.add_argument("source", type=Path, metavar="SOURCE", help=SOURCE_HELP)
    parser.add_argument(
        "--output", type=Path, metavar="TORQUE.csv", help="write the torques as CSV"
    )
    parser.add_argument(
        "--terms", action="store_true", help="with --output: the parts of the torque too"
    )
    parser.add_argument(
        "--intervals",
        action="store_true",
        help="how sure the model is: a 90 %% interval of every torque",
    )
    add_topic(parser)
    add_conditioning(parser)
    add_effects_file(parser)
    add_json(parser)
    add_force(parser)


def run(arguments: Namespace) -> int:
    """See `Command`."""
    console = Console(arguments.json)
    _check_outputs(arguments)
    load_own_effects(arguments, console)
    from lagrangian_ff.diagnosis import compare, with_intervals

    held = Held.of(arguments, console)
    model, (motion,) = held.model, held.motions([arguments.source], console)
    with progress_bar("predicting") as progress:
        comparison = compare(model, motion, progress=progress)
    if arguments.intervals:
        with progress_bar("asking how sure it is") as progress:
            comparison = with_intervals(model, comparison, progress)
    if arguments.output is not None:
        write_table(arguments.output, _columns(model, comparison, arguments.terms))
    record = {"model": str(arguments.model), **comparison.record()}
    write_record(arguments.json, record)
    console.say(f"{arguments.model} ({model.name}) on {motion.source}")
    console.say(error_table(record))
    console.paragraph(LEGEND, "  ")
    console.say()
    console.paragraph(verdict(record))
    away = leaving(model, motion.time, (motion.q, motion.qd, motion.qdd))
    if away.share > 0.0:
        console.note(
            f"{away.share:.1%} of the motion lies outside what the model was identified on "
            f"({away.worst}): {away.when()}. There it guesses; identify from this recording too "
            "if such motions matter",
            "",
        )
    if comparison.interval is not None:
        console.paragraph(covered(record))
        if record["too_sure"]:
            console.note(str(record["too_sure"]), "")
    if arguments.output is not None:
        console.say(f"saved: {arguments.output}")
    return 0


def _check_outputs(arguments: Namespace) -> None:
    if arguments.terms and arguments.output is None:
        raise UserError("--terms says what goes into the CSV: name one with --output")
    inputs = [arguments.model, arguments.source]
    if arguments.output is not None:
        check_file(arguments.output, "--output", force=arguments.force, suffix=".csv", keep=inputs)
        inputs.append(arguments.output)
    if arguments.json not in (None, "-"):
        check_file(Path(arguments.json), "--json", force=arguments.force, keep=inputs)


def _columns(model: "Model", comparison: "Comparison", terms: bool) -> "Columns":
    motion = comparison.motion
    parts = {"measured": motion.tau, "predicted": comparison.predicted}
    if comparison.interval is not None:
        reach = comparison.interval.reach
        parts |= {"low": comparison.predicted - reach, "high": comparison.predicted + reach}
    if terms:
        states = motion.q, motion.qd, motion.qdd
        found = model.terms(*states, time=motion.time, segment=motion.segment)
        parts |= {name: getattr(found, name) for name in ("gravity", "inertia", "coriolis")}
        parts |= found.effects
    columns = {"time": motion.time}
    for name, values in parts.items():
        columns |= {f"{name}/{joint}": values[:, n] for n, joint in enumerate(model.joints)}
    return columns
