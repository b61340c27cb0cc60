"""`identify`: from recordings to a model file, and how good it is."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common import options, sources
from lagrangian_ff.cli.common.console import Console, progress_bar
from lagrangian_ff.cli.common.outputs import check_outputs, check_sources, whole, write_record
from lagrangian_ff.cli.text.advice import FAIR, Findings, advice, usable
from lagrangian_ff.cli.text.errors import verdict, worse_than
from lagrangian_ff.cli.text.model import say_record

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
    # Defaults of the identification stand in its Settings alone.
    options.add_sources(parser, "learned from together")
    parser.add_argument(
        "--output", required=True, type=Path, metavar="MODEL.npz", help="the model file to write"
    )
    parser.add_argument(
        "--model", metavar="NAME", help="kernel and effects, see below (default: auto+fri)"
    )
    options.add_list(
        parser, "--joints", "JOINT",
        "learn these only, a,b or a b (default: all that were recorded)",
    )  # fmt: skip
    parser.add_argument("--urdf", type=Path, metavar="FILE",
        help="the robot's description: its rigid bodies become part of the model, their masses "
        "corrected from those of the file, and the kernel corrects the rest (needs the extra urdf)",
    )  # fmt: skip
    options.add_list(
        parser, "--prismatic", "JOINT",
        "these slide, in m and N, a,b or a b; auto, chain and energy need to know it, a URDF "
        "says it itself (default: all turn)",
    )  # fmt: skip
    group = parser.add_argument_group("how it is learned and judged")
    group.add_argument("--train", type=float, metavar="FRACTION",
        help="the part of each recording to learn from, from its beginning (default: 2/3); with "
        "1.0 all of it, and judged on blocks left out in turn")  # fmt: skip
    group.add_argument("--samples", type=int, metavar="M",
        help="training samples an exact model is built on, evenly spread (default: 500); the time "
        "grows with the cube; more than 1500 of six joints turn to --landmarks")  # fmt: skip
    group.add_argument("--landmarks", type=int, metavar="C",
        help="build the kernel on C samples and learn from all of them, in time linear in the "
        "recording; 0: an exact model of --samples (default: 0 for up to two minutes of training "
        "motion, 300 for more)")  # fmt: skip
    group.add_argument("--block", dest="block_seconds", type=float, metavar="SECONDS",
        help="length of the blocks of cross-validation (default: 3)")  # fmt: skip
    group.add_argument(
        "--folds", type=int, help="in how many turns the blocks are left out (default: 5)"
    )
    group.add_argument("--selection", choices=("validation", "evidence"),
        help="what hyperparameters are chosen by (default: validation, blocks left out)",
    )  # fmt: skip
    group.add_argument("--scale", choices=("auto", "joint", "common"),
        help="joint: each torque counts by its own spread; common: one unit for all, so that the "
        "torques derive from one Lagrangian; auto: whichever does better (default: auto)",
    )  # fmt: skip
    group.add_argument("--positive", action="store_true",
        help="keep the mass matrix positive definite along the training motion, for simulation and "
        "control with it; the joints then have one torque scale")  # fmt: skip
    group.add_argument("--loss", choices=("square", "huber"),
        help="what a residual costs: huber is for recordings with contacts or other gross errors, "
        "which it weighs down and reports (default: square)")  # fmt: skip
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
    readings = [sources.prepare(recording, conditioning, console) for recording in recordings]
    from lagrangian_ff.identification import identify

    with progress_bar("identifying") as progress:
        found = identify([reading.motion for reading in readings], settings, progress, robot)
    with whole(arguments.output) as path:
        found.model.save(path)
    write_record(arguments.json, found.record)
    for note in _own_notes(found, readings):
        console.note(note, "  ")
    _say(found, readings, arguments.output, console)
    return 0


def _own_notes(found: "Identification", readings: list[sources.Reading]) -> list[str]:
    """Return the notes of the identification itself; those of the recordings are out already."""
    known = {note for reading in readings for note in reading.motion.notes}
    notes = found.record["notes"]
    assert isinstance(notes, list)
    return [note for note in notes if note not in known]


def _settings(arguments: Namespace) -> "Settings":
    from lagrangian_ff.identification import Settings
    from lagrangian_ff.identification.spec import parse, require_sliding

    known = (
        "model", "train", "samples", "block_seconds", "folds", "selection", "scale", "positive",
        "landmarks", "loss",
    )  # fmt: skip
    given = {name: getattr(arguments, name) for name in known}
    given["prismatic"] = options.names(arguments.prismatic)
    settings = Settings(**{name: value for name, value in given.items() if value is not None})
    settings.check()
    require_sliding(parse(settings.model), settings.prismatic, known=arguments.urdf is not None)
    return settings


def _say(
    found: "Identification", readings: list[sources.Reading], output: Path, console: Console
) -> None:
    say_record(found.record, console)
    held_out = found.held_out
    away = sources.out_of_range(found.model, held_out.time, (held_out.q, held_out.qd, held_out.qdd))
    still = tuple(
        dict.fromkeys(
            joint.name for reading in readings for joint in reading.inspection.joints if joint.still
        )
    )
    console.say()
    console.paragraph(f"{verdict(found.record)} {usable(found.record)}")
    for text in advice(Findings(found.record, away.share, away.worst, still)):
        console.bullet(text)
    console.say(f"saved: {output}")
    if not worse_than(found.record, FAIR):
        console.say(f"""next:
  lagrangian_ff compare {output} OTHER_RECORDING      where does it fail?
  lagrangian_ff diagnose {output} OTHER_RECORDING     what is missing in it?
  lagrangian_ff feedforward {output} TRAJECTORY.csv --output torque.csv""")
