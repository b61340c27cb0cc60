"""`compare`: where a model fails on recordings."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

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
from lagrangian_ff.cli.common.outputs import check_file, whole, write_record
from lagrangian_ff.cli.common.own_effects import add_effects_file, load_own_effects
from lagrangian_ff.cli.common.progress import progress_bar
from lagrangian_ff.cli.text.compare import next_step, say_where
from lagrangian_ff.cli.text.errors import LEGEND, error_table, verdict
from lagrangian_ff.errors import UserError

NAME = "compare"
SUMMARY = "see where a model fails: in which region of speed, position, load, direction or time"
USAGE = "MODEL SOURCE [SOURCE ...] [options]"
DESCRIPTION = """\
Compares a model with recordings, those it was identified from or others, and tells where its error
lies: the error of each joint, and the few regions of speed, position, acceleration, load, time,
direction or time around reversals that hold most of it. On a recording made later, this is what
changed since."""
EPILOG = """\
examples:
  lagrangian_ff compare model.npz other_bag
  lagrangian_ff compare model.npz bag_1 bag_2 --report where.html --json where.json

what comes out:
  the error of each joint in N·m (rmse) and as a share of its torque's variance (nmse);
  whether the measured torques lie inside the model's 90 % intervals, as --json says by joint
  (covered): a warning where far fewer do;
  regions such as `joint_2 below 0.1 rad/s: 41 % of its error in 6 % of the time`. A region is
  named only if error spread at random over the motion would hardly show one so striking;
  with --report one page with everything to look at, which opens without a network: torques over
  time with their 90 % intervals, the residual over each quantity with bands of chance, and its
  waves over each joint's angle."""


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("model", type=Path, metavar="MODEL", help="a model file of identify")
    parser.add_argument(
        "sources",
        type=Path,
        nargs="+",
        metavar="SOURCE",
        help=f"{SOURCE_HELP}; several are judged together",
    )
    parser.add_argument(
        "--report", type=Path, metavar="FILE.html", help="write a page with interactive figures"
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
    from threadpoolctl import threadpool_limits

    from lagrangian_ff.diagnosis import compare
    from lagrangian_ff.diagnosis.where import locate
    from lagrangian_ff.recording.motion import concatenate

    held = Held.of(arguments, console)
    model, motions = held.model, held.motions(arguments.sources, console)
    motion = concatenate(motions) if len(motions) > 1 else motions[0]
    # What BLAS is given here is small: a second thread would mostly wait for it, busily.
    with progress_bar("predicting") as progress, threadpool_limits(1):
        comparison = compare(model, motion, progress=progress, intervals=True)
    with progress_bar("looking where it fails") as progress, threadpool_limits(1):
        where = locate(model, comparison, progress=progress)
    names = {
        "model": str(arguments.model),
        "sources": [str(source) for source in arguments.sources],
    }
    record = {**names, **where.record()}
    if arguments.report is not None:
        from lagrangian_ff.report import compare_page

        with whole(arguments.report) as path:
            compare_page(path, {**names, **where.record(series=True)})
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
            f"({away.worst}): {away.when()}. There it guesses",
            "",
        )
    if record.get("too_sure"):
        console.note(str(record["too_sure"]), "")
    console.say()
    say_where(record, console)
    console.say()
    if arguments.report is not None:
        console.say(f"saved: {arguments.report}")
    console.say(next_step(record))
    return 0


def _check_outputs(arguments: Namespace) -> None:
    for source in arguments.sources:
        if not source.exists():
            raise UserError(f"{source}: no such file or directory")
    keep = [arguments.model, *arguments.sources]
    if arguments.report is not None:
        check_file(arguments.report, "--report", force=arguments.force, suffix=".html", keep=keep)
        keep.append(arguments.report)
    if arguments.json not in (None, "-"):
        check_file(Path(arguments.json), "--json", force=arguments.force, keep=keep)
