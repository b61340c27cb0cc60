"""`predict`: the torque that a model predicts for a recording, and how far it is off."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console, progress_bar
from lagrangian_ff.cli.common.outputs import check_outputs, write_record, write_table
from lagrangian_ff.cli.common.sources import LoadedModel, out_of_range, warn_of_curves
from lagrangian_ff.cli.text.errors import covered, say_errors
from lagrangian_ff.errors import UserError

if TYPE_CHECKING:
    from lagrangian_ff.arrays import Floats
    from lagrangian_ff.diagnosis import Comparison
    from lagrangian_ff.identification import Model


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
    options.add_model(parser)
    parser.add_argument("source", type=Path, metavar="SOURCE", help=options.SOURCE_HELP)
    written = [
        ("--output", Path, "TORQUE.csv", "write the torques as CSV"),
        ("--terms", bool, "", "with --output: the parts of the torque too"),
        ("--intervals", bool, "", "how sure the model is: a 90 %% interval of every torque"),
    ]
    options.add_rows(parser, written)
    options.add_reading(parser)
    options.add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    if arguments.terms and arguments.output is None:
        raise UserError("--terms says what goes into the CSV: name one with --output")
    check_outputs(arguments, [arguments.model, arguments.source], ".csv")
    options.load_own_effects(arguments, console)
    from lagrangian_ff.diagnosis import compare, with_intervals

    loaded = LoadedModel.of(arguments, console)
    model, (motion,) = loaded.model, loaded.motions([arguments.source], console)
    with progress_bar("predicting") as progress:
        comparison = compare(model, motion, progress=progress)
    if arguments.intervals:
        with progress_bar("finding out how sure it is") as progress:
            comparison = with_intervals(model, comparison, progress)
    if arguments.output is not None:
        parts = _parts(model, comparison, terms=arguments.terms)
        write_table(arguments.output, motion.time, parts, model.joints)
    write_record(arguments.json, {"model": str(arguments.model), **comparison.record()})
    console.say(f"{arguments.model} ({model.name}) on {motion.source}")
    say_errors(comparison.score, console)
    states = motion.q, motion.qd, motion.qdd
    away = out_of_range(model, motion.time, states)
    then = "There it guesses; identify from this recording too if such motions matter"
    away.warn("motion", "the model", f": {away.when()}. {then}", console)
    warn_of_curves(model, motion.time, states, "motion", console)
    if comparison.interval is not None:
        console.paragraph(covered(comparison.interval))
        if comparison.warning:
            console.note(comparison.warning)
    if arguments.output is not None:
        console.say(f"saved: {arguments.output}")
    return 0


def _parts(model: "Model", comparison: "Comparison", *, terms: bool) -> "dict[str, Floats]":
    """Return what the CSV holds of each joint, (M, N) N·m by name."""
    motion = comparison.motion
    parts = {"measured": motion.tau, "predicted": comparison.predicted}
    if comparison.interval is not None:
        reach = comparison.interval.reach
        parts |= {"low": comparison.predicted - reach, "high": comparison.predicted + reach}
    if terms:
        states = motion.q, motion.qd, motion.qdd
        found = model.terms(
            *states, time=motion.time, segment=motion.segment, temperature=motion.temperature
        )
        parts |= {name: getattr(found, name) for name in ("gravity", "inertia", "coriolis")}
        parts |= found.effects
    return parts
