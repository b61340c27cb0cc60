"""`identify`: from recordings to a model file, and how good it is."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.known_robot import known_robot
from lagrangian_ff.cli.common.leaving import leaving
from lagrangian_ff.cli.common.options import (
    SOURCE_HELP,
    add_conditioning,
    add_force,
    add_json,
    add_topic,
    conditioning_of,
    names,
)
from lagrangian_ff.cli.common.outputs import check_file, whole, write_record
from lagrangian_ff.cli.common.own_effects import add_effects_file, load_own_effects
from lagrangian_ff.cli.common.progress import progress_bar
from lagrangian_ff.cli.common.sources import (
    Reading,
    prepare,
    read,
    require_same_joints,
)
from lagrangian_ff.cli.text.advice import FAIR, Findings, advice, usable
from lagrangian_ff.cli.text.errors import verdict, worse_than
from lagrangian_ff.cli.text.model import say_record
from lagrangian_ff.errors import UserError

if TYPE_CHECKING:
    from lagrangian_ff.identification import Identification, Settings

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
  kernels  auto (the usual): chain or chain_rbf, whichever predicts blocks left out better;
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
    """See `Command`. Defaults of the identification stand in its Settings alone."""
    parser.add_argument(
        "sources",
        nargs="+",
        type=Path,
        metavar="SOURCE",
        help=f"{SOURCE_HELP}; several are learned from together",
    )
    parser.add_argument(
        "--output", required=True, type=Path, metavar="MODEL.npz", help="the model file to write"
    )
    parser.add_argument(
        "--model", metavar="NAME", help="kernel and effects, see below (default: auto+fri)"
    )
    parser.add_argument(
        "--joints",
        nargs="+",
        action="extend",
        metavar="JOINT",
        help="learn these only, a,b or a b (default: all that were recorded)",
    )
    parser.add_argument(
        "--urdf",
        type=Path,
        metavar="FILE",
        help="the robot's description: its rigid bodies become part of the model, their masses "
        "corrected from those of the file, and the kernel corrects the rest (needs the extra urdf)",
    )
    parser.add_argument(
        "--prismatic",
        nargs="+",
        action="extend",
        default=[],
        metavar="JOINT",
        help="these slide, in m and N, a,b or a b; auto, chain and energy want to know it, a URDF "
        "says it itself (default: all turn)",
    )
    add_topic(parser)
    group = parser.add_argument_group("how it is learned and judged")
    group.add_argument(
        "--train",
        type=float,
        metavar="FRACTION",
        help="the part of each recording to learn from, from its beginning (default: 2/3); with "
        "1.0 all of it, and judged on blocks left out in turn",
    )
    group.add_argument(
        "--samples",
        type=int,
        metavar="M",
        help="training samples an exact model is built on, evenly spread (default: 500); "
        "the time grows with the cube; more than 1500 of six joints turn to --landmarks",
    )
    group.add_argument(
        "--landmarks",
        type=int,
        metavar="C",
        help="build the kernel on C samples and learn from all of them, in time linear in the "
        "recording; 0: an exact model of --samples (default: 0 for up to two minutes of training "
        "motion, 300 for more)",
    )
    group.add_argument(
        "--block",
        dest="block_seconds",
        type=float,
        metavar="SECONDS",
        help="length of the blocks of cross-validation (default: 3)",
    )
    group.add_argument(
        "--folds", type=int, help="in how many turns the blocks are left out (default: 5)"
    )
    group.add_argument(
        "--selection",
        choices=("validation", "evidence"),
        help="what hyperparameters are chosen by (default: validation, blocks left out)",
    )
    group.add_argument(
        "--scale",
        choices=("auto", "joint", "common"),
        help="joint: each torque counts by its own spread; common: one unit for all, so that the "
        "torques derive from one Lagrangian; auto: whichever does better (default: auto)",
    )
    group.add_argument(
        "--positive",
        action="store_true",
        help="keep the mass matrix positive definite along the training motion, for simulation and "
        "control with it; the joints then have one torque scale",
    )
    group.add_argument(
        "--loss",
        choices=("square", "huber"),
        help="what a residual costs: huber is for recordings with contacts or other gross errors, "
        "which it weighs down and tells (default: square)",
    )
    add_conditioning(parser)
    add_effects_file(parser)
    add_json(parser)
    add_force(parser)


def run(arguments: Namespace) -> int:
    """See `Command`."""
    console = Console(arguments.json)
    load_own_effects(arguments, console)
    settings = _settings(arguments)
    _check_outputs(arguments)
    robot = known_robot(arguments.urdf)
    conditioning = conditioning_of(arguments)
    joints = names(arguments.joints or [])
    recordings = [read(path, arguments.topic) for path in arguments.sources]
    if joints:
        recordings = [recording.select(joints) for recording in recordings]
    require_same_joints(recordings)
    readings = [prepare(recording, conditioning, console) for recording in recordings]
    from lagrangian_ff.identification import identify

    with progress_bar("identifying") as progress:
        found = identify([reading.motion for reading in readings], settings, progress, robot)
    with whole(arguments.output) as path:
        found.model.save(path)
    write_record(arguments.json, found.record)
    for note in _own_notes(found, readings):
        console.note(note)
    _say(found, readings, arguments.output, console)
    return 0


def _own_notes(found: "Identification", readings: list[Reading]) -> list[str]:
    """What the identification itself has to say; the recordings' notes are told already."""
    told = {note for reading in readings for note in reading.motion.notes}
    notes = found.record["notes"]
    assert isinstance(notes, list)
    return [note for note in notes if note not in told]


def _settings(arguments: Namespace) -> "Settings":
    from lagrangian_ff.identification import Settings
    from lagrangian_ff.identification.sliding import require_sliding
    from lagrangian_ff.identification.spec import parse

    options = (
        "model", "train", "samples", "block_seconds", "folds", "selection", "scale", "positive",
        "landmarks", "loss",
    )  # fmt: skip
    given = {name: getattr(arguments, name) for name in options}
    given["prismatic"] = names(arguments.prismatic)
    settings = Settings(**{name: value for name, value in given.items() if value is not None})
    settings.check()
    require_sliding(parse(settings.model), settings.prismatic, known=arguments.urdf is not None)
    return settings


def _check_outputs(arguments: Namespace) -> None:
    for path in arguments.sources:
        if not path.exists():
            raise UserError(f"{path}: no such file or directory")
    force, output = arguments.force, arguments.output
    read = [*arguments.sources, *([arguments.urdf] if arguments.urdf else [])]
    check_file(output, "--output", force=force, suffix=".npz", keep=read)
    if arguments.json not in (None, "-"):
        check_file(Path(arguments.json), "--json", force=force, keep=[output, *read])


def _say(found: "Identification", readings: list[Reading], output: Path, console: Console) -> None:
    say_record(found.record, console)
    held_out = found.held_out
    away = leaving(found.model, held_out.time, (held_out.q, held_out.qd, held_out.qdd))
    still = tuple(
        dict.fromkeys(
            joint.name for reading in readings for joint in reading.inspection.joints if joint.still
        )
    )
    console.say()
    console.paragraph(f"{verdict(found.record)} {usable(found.record)}")
    for text in advice(Findings(found.record, away.share, away.worst, still)):
        console.paragraph(text, "  - ", "    ")
    console.say(f"saved: {output}")
    if not worse_than(found.record, FAIR):
        console.say(
            [
                "next:",
                f"  lagrangian_ff compare {output} OTHER_RECORDING      where does it fail?",
                f"  lagrangian_ff diagnose {output} OTHER_RECORDING     what is missing in it?",
                f"  lagrangian_ff feedforward {output} TRAJECTORY.csv --output torque.csv",
            ]
        )
