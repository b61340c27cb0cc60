"""`compare`: where a model fails on recordings."""

from argparse import ArgumentParser, Namespace

from lagrangian_ff import report
from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console, progress_bar
from lagrangian_ff.cli.common.outputs import check_outputs, check_sources, whole, write_record
from lagrangian_ff.cli.common.sources import LoadedModel, out_of_range
from lagrangian_ff.cli.text.errors import next_step, say_errors, say_where

NAME = "compare"
SUMMARY = "see where a model fails: in which region of speed, position, load, direction or time"
USAGE = "MODEL SOURCE [SOURCE ...] [options]"
DESCRIPTION = """\
Compares a model with recordings, those it was identified from or others, and says where its error
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
    options.add_model(parser)
    options.add_sources(parser, "judged together")
    options.add_report(parser)
    options.add_reading(parser)
    options.add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    check_sources(arguments.sources)
    check_outputs(arguments, [arguments.model, *arguments.sources])
    options.load_own_effects(arguments, console)
    from lagrangian_ff.diagnosis import compare
    from lagrangian_ff.diagnosis.where import Compared, locate
    from lagrangian_ff.kernels.threads import one_blas_thread
    from lagrangian_ff.recording.motion import concatenate

    loaded = LoadedModel.of(arguments, console)
    model, motions = loaded.model, loaded.motions(arguments.sources, console)
    motion = concatenate(motions) if len(motions) > 1 else motions[0]
    # What BLAS is given here is small: a second thread would mostly wait for it, busily.
    with progress_bar("predicting") as progress, one_blas_thread():
        comparison = compare(model, motion, progress=progress, intervals=True)
    with progress_bar("looking where it fails") as progress, one_blas_thread():
        where = locate(model, comparison, progress=progress)
    found = Compared(str(arguments.model), tuple(map(str, arguments.sources)), where)
    if arguments.report is not None:
        with whole(arguments.report) as path:
            report.compare_page(path, found)
    write_record(arguments.json, found.record())
    console.say(f"{arguments.model} ({model.name}) on {motion.source}")
    say_errors(comparison.score, console)
    away = out_of_range(model, motion.time, (motion.q, motion.qd, motion.qdd))
    away.warn("motion", "the model", f": {away.when()}. There it guesses", console)
    if comparison.warning:
        console.note(comparison.warning)
    console.say()
    say_where(where, console)
    console.say()
    if arguments.report is not None:
        console.say(f"saved: {arguments.report}")
    console.say(next_step(found.model, found.sources))
    return 0
