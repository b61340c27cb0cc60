"""`identify`: from recordings to a model file, and how good it is."""

from argparse import ArgumentParser, Namespace
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common import options, sources
from lagrangian_ff.cli.common.console import Console, progress_bar
from lagrangian_ff.cli.common.outputs import check_outputs, check_sources, whole, write_record
from lagrangian_ff.cli.text.advice import FAIR, Findings, advice, usable
from lagrangian_ff.cli.text.diagnose import say_checks
from lagrangian_ff.cli.text.errors import verdict, worse_than
from lagrangian_ff.cli.text.model import say_identified

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis.preflight import Check
    from lagrangian_ff.identification import Identification, Settings
    from lagrangian_ff.kernels import Mechanism

NAME = "identify"
SUMMARY = "learn a model from recordings and see how good it is"
USAGE = "SOURCE [SOURCE ...] --output MODEL.npz [options]"
DESCRIPTION = """\
Learns the inverse dynamics of an arm, torque from position, velocity and acceleration, from
recordings alone, and writes it to a model file. Each recording is cut in time: the model learns
from the first part and is judged on the rest, which it has not seen."""
EPILOG = """\
examples:
  lagrangian_ff identify bag --output model.npz
  lagrangian_ff identify bag --train 1.0 --output model.npz       learn from all of it
  lagrangian_ff identify a.csv b.csv --joints base,elbow --output model.npz
  lagrangian_ff identify bag --effort-scale elbow=13.4 wrist=-9.1 --output model.npz
  lagrangian_ff identify bag --urdf robot.urdf --output model.npz   the bodies are known
  lagrangian_ff identify bag --prismatic rail --output model.npz    rail slides: m and N

what comes out:
  what was found in each recording, and what was done to it;
  the error of the predicted torque on motion the model has not seen, joint by joint:
      rmse in N·m, and nmse, the share of the torque's variance that is missed
      (below 0.05 is good; 1 is no better than a constant);
  the effects (friction) as equations, with 90 % intervals of their numbers;
  whether that is good or bad, and what to do next.

models are one kernel and any number of effects, joined by +:
  kernels  auto (the usual): chain, or chain_rbf if it predicts blocks left out surely better;
           chain, chain_rbf: kinetic energy quadratic in velocity, gravity apart, of a serial
           arm, joints given from the base to the tool; energy, energy_rbf: of any arm;
           vrbfs, vrbf, svrbfs, svrbf, srbfs, srbf: the paper's, from a Lagrangian, of which
           vrbfs and vrbf couple the joints; pol, motor: the paper's benchmarks, rigid bodies
           and joints by themselves; rbf, rbfs: assume nothing; none
  effects  fri = viscous+coulomb+offset, or each by its name; any other of `lagrangian_ff effects`
           on all joints, or on one: vrbfs+fri+stribeck@joint_2. Which ones are missing is what
           lagrangian_ff diagnose finds out

Put the sources first: names after --joints, --prismatic or --effort-scale are taken for joints."""


def add_arguments(parser: ArgumentParser) -> None:
    # Defaults of the identification stand in its Settings alone.
    options.add_sources(parser, "learned from together")
    parser.add_argument(
        "--output", required=True, type=Path, metavar="MODEL.npz", help="the model file to write"
    )
    options.add_rows(parser, (
        ("--model", str, "NAME", "kernel and effects, see below (default: auto+fri; "
         "auto with --effort without-friction)"),
        ("--joints", list, "JOINT",
         "learn these only, a,b or a b, from base to tool (default: all that were recorded, in the "
         "order of the URDF, else of their numbers, else of what the torques speak for)"),
        ("--urdf", Path, "FILE",
         "the robot's description: its rigid bodies become part of the model, their masses "
         "corrected from those of the file, and the kernel corrects the rest (needs the extra "
         "urdf)"),
        ("--prismatic", list, "JOINT",
         "these slide, in m and N, a,b or a b; auto, chain and energy need to know it, a URDF "
         "says it itself (default: all turn)"),
    ))  # fmt: skip
    options.add_rows(parser.add_argument_group("how it is learned and judged"), (
        ("--train", float, "FRACTION",
         "the part of each recording to learn from, from its beginning (default: 2/3); with 1.0 "
         "all of it, and judged on blocks left out in turn"),
        ("--samples", int, "M",
         "training samples an exact model is built on, evenly spread (default: 500); the time "
         "grows with the cube; more than 1500 of six joints turn to "
         "--inducing-points"),
        ("--inducing-points --landmarks", int, "C",
         "build the kernel on C samples and learn from all of them, in time linear in the "
         "recording; 0: an exact model of --samples (default: 0 for up to two minutes of training "
         "motion, 300 for more, or where that is cheap, as for two joints)"),
        ("--block", float, "SECONDS", "length of the blocks of cross-validation (default: 3)"),
        ("--folds", int, "", "in how many turns the blocks are left out (default: 5)"),
        ("--selection", ("validation", "evidence"), "",
         "what hyperparameters are chosen by (default: validation, blocks left out)"),
        ("--scale", ("auto", "joint", "common"), "",
         "joint: each torque counts by its own spread; common: one unit for all, so that the "
         "torques derive from one Lagrangian; auto: whichever does better, or one unit with gains "
         "of the joints that the data ask for (default: auto)"),
        ("--positive", bool, "",
         "keep the mass matrix positive definite along the training motion, for simulation and "
         "control with it; the joints then have one torque scale"),
        ("--loss", ("square", "huber"), "",
         "what a residual costs: huber is for recordings with contacts or other gross errors, "
         "which it weighs down and reports (default: square)"),
    ))  # fmt: skip
    options.add_reading(parser)
    options.add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    options.load_own_effects(arguments, console)
    settings = _settings(arguments)
    check_sources(arguments.sources)
    check_outputs(arguments, [*arguments.sources, arguments.urdf], ".npz")
    robot = None
    if arguments.urdf is not None:
        from lagrangian_ff.kernels.rigid import read_urdf

        robot = read_urdf(arguments.urdf)
    conditioning = options.conditioning_of(arguments)
    joints = options.names(arguments.joints)
    recordings = [sources.read(path, arguments.topic) for path in arguments.sources]
    if joints:
        recordings = [recording.select(joints) for recording in recordings]
    sources.require_same_joints(recordings)
    readings = sources.prepare(recordings, conditioning, console)
    if not joints:
        readings = _base_to_tool(readings, settings, robot, console)
    from lagrangian_ff.diagnosis.record import check_record
    from lagrangian_ff.identification import identify

    with progress_bar("identifying") as progress:
        found = identify([reading.motion for reading in readings], settings, progress, robot)
    with whole(arguments.output) as path:
        found.model.save(path)
    checks = _checks(found, readings)
    write_record(arguments.json, {**found.record, "preflight": [check_record(c) for c in checks]})
    known = {note for reading in readings for note in reading.motion.notes}  # they are out already
    for note in found.model.identified.notes:
        if note not in known:
            console.note(note, "  ")
    say_checks(checks, console)
    _say(found, readings, arguments.output, console)
    return 0


def _base_to_tool(
    readings: list[sources.Reading],
    settings: "Settings",
    robot: "Mechanism | None",
    console: Console,
) -> list[sources.Reading]:
    """Return the readings with their joints in the order from base to tool."""
    from lagrangian_ff.identification import joint_order

    motions = [reading.motion for reading in readings]
    with progress_bar("the order of the joints") as progress:
        order = joint_order(motions, settings.model, robot, progress)
    if words := order.words(motions[0].joints):
        console.note(f"{words}; --joints gives another order")
    return [replace(one, motion=one.motion.select(order.joints)) for one in readings]


def _checks(found: "Identification", readings: list[sources.Reading]) -> "list[Check]":
    """Return what the torques show of what the effort holds."""
    from lagrangian_ff.diagnosis.preflight import effort_checks
    from lagrangian_ff.recording.motion import concatenate

    with progress_bar("looking at what the effort holds"):
        return effort_checks(found.model, concatenate([one.motion for one in readings]))


def _settings(arguments: Namespace) -> "Settings":
    from lagrangian_ff.identification import Settings
    from lagrangian_ff.identification.settings import usual_model
    from lagrangian_ff.identification.spec import parse, require_sliding
    from lagrangian_ff.recording.motion import TOTAL

    known = {field.name for field in fields(Settings)}
    given = {name: v for name, v in vars(arguments).items() if name in known and v is not None}
    given.setdefault("model", usual_model(arguments.effort or TOTAL))
    given["prismatic"] = options.names(arguments.prismatic)
    for option, name in (("block", "block_seconds"), ("inducing_points", "landmarks")):
        if (value := getattr(arguments, option)) is not None:
            given[name] = value
    settings = Settings(**given)
    settings.check()
    require_sliding(parse(settings.model), settings.prismatic, known=arguments.urdf is not None)
    return settings


def _say(
    found: "Identification", readings: list[sources.Reading], output: Path, console: Console
) -> None:
    identified, held_out = found.model.identified, found.held_out
    say_identified(identified, console)
    away = sources.out_of_range(found.model, held_out.time, (held_out.q, held_out.qd, held_out.qdd))
    still = tuple(
        dict.fromkeys(
            joint.name for reading in readings for joint in reading.inspection.joints if joint.still
        )
    )
    console.say()
    console.paragraph(f"{verdict(identified.score)} {usable(identified.score)}")
    for text in advice(Findings(identified, away.share, away.worst, still)):
        console.bullet(text)
    console.say(f"saved: {output}")
    if not worse_than(identified.score, FAIR):
        console.say(f"""next:
  lagrangian_ff compare {output} OTHER_RECORDING      where does it fail?
  lagrangian_ff diagnose {output} OTHER_RECORDING     what is missing in it?
  lagrangian_ff feedforward {output} TRAJECTORY.csv --output torque.csv""")
