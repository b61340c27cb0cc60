"""`calibrate`: N·m per unit of effort of each joint, from motion with and without a known load."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common import options, sources
from lagrangian_ff.cli.common.console import Console, progress_bar, table
from lagrangian_ff.cli.common.outputs import check_outputs, check_sources, write_record
from lagrangian_ff.errors import UserError
from lagrangian_ff.numbers import number

if TYPE_CHECKING:
    from lagrangian_ff.identification.drive_gains import DriveGains
    from lagrangian_ff.recording import Conditioning, Motion

NAME = "calibrate"
SUMMARY = "find N·m per unit of effort of each joint, from motion with and without a known load"
USAGE = "UNLOADED LOADED --payload KG --urdf FILE [options]"
DESCRIPTION = """\
Finds the drive gains: the torque in N·m that a unit of each joint's effort makes, such as a motor
current. It takes a recording of the arm without a load, one with a load of known mass at its end,
and the arm's kinematics. All joints are found at once; masses, rotors, friction and offsets need
not be known."""
EPILOG = """\
examples:
  lagrangian_ff calibrate empty carrying --payload 2.5 --urdf robot.urdf
  lagrangian_ff calibrate empty carrying --payload 2.5 --payload-centre 0 0 0.08 --urdf robot.urdf
  lagrangian_ff calibrate a c --unloaded b --loaded d --payload 2.5 --urdf robot.urdf

what comes out:
  N·m per unit of effort of each joint with a 90 % interval, as wide as blocks of 2 s differ;
  not identified: joints whose torque the load changes too little, with their interval;
  the option --effort-scale with which other commands read such recordings.

what it takes:
  motion in which every joint moves through its range at several speeds, half a minute or more of
  each kind; it need not be the same motion. The heavier the load, the better;
  the mass of the load: an error of 5 % makes all gains wrong by 5 %. Where its centre is known,
  --payload-centre says so, and the gains of wrists are better known;
  a URDF, of which only the lengths and axes are used. The load's torque is its weight times its
  lever arms: without them the recordings do not say what a unit of effort is in N·m."""


def add_arguments(parser: ArgumentParser) -> None:
    for name, kind in (("unloaded", "without the load"), ("loaded", "with the load")):
        text = f"{options.SOURCE_HELP}, {kind}"
        parser.add_argument(f"{name}_source", type=Path, metavar=name.upper(), help=text)
    options.add_rows(parser, [
        ("--payload", float, "KG", "the mass of the load at the end of the arm"),
        ("--urdf", Path, "FILE", "the arm's description, for its kinematics (needs extra urdf)"),
    ])  # fmt: skip
    parser.add_argument(
        "--payload-centre",
        type=float,
        nargs=3,
        metavar=("X", "Y", "Z"),
        help="m, the load's centre of mass in the frame of the last joint (default: found)",
    )
    options.add_list(parser, "--unloaded", "SOURCE", "further recordings without the load", Path)
    options.add_list(parser, "--loaded", "SOURCE", "further recordings with the load", Path)
    options.add_list(parser, "--joints", "JOINT", "these only, a,b or a b (default: all recorded)")
    options.add_reading(parser)
    options.add_common(parser, effects=False)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    unloaded = [arguments.unloaded_source, *arguments.unloaded]
    loaded = [arguments.loaded_source, *arguments.loaded]
    _check(arguments, unloaded, loaded)
    from lagrangian_ff.identification.drive_gains import drive_gains
    from lagrangian_ff.kernels.rigid import read_urdf

    robot = read_urdf(arguments.urdf)
    conditioning = options.conditioning_of(arguments)
    motions = _motions([*unloaded, *loaded], arguments, conditioning, console)
    empty, carrying = motions[: len(unloaded)], motions[len(unloaded) :]
    with progress_bar("calibrating") as progress:
        found = drive_gains(
            empty, carrying, robot, arguments.payload, arguments.payload_centre, progress
        )
    scale = _scale(found, conditioning)
    option = " ".join(f"{joint}={value:.4g}" for joint, value in scale.items())
    write_record(arguments.json, {**found.record(), "effort_scale": scale})
    _say(found, conditioning, console)
    if scale:
        console.say(["", f"--effort-scale {option}"])
    return 0


def _check(arguments: Namespace, unloaded: list[Path], loaded: list[Path]) -> None:
    every = [*unloaded, *loaded]
    check_sources(every)
    check_outputs(arguments, [*every, arguments.urdf])
    if arguments.payload is None:
        raise UserError("--payload is missing: the mass of the load in kg sets the scale")
    if not arguments.payload > 0.0:
        raise UserError(f"--payload {arguments.payload:g}: expected a mass in kg above 0")
    if arguments.urdf is None:
        raise UserError(
            "--urdf is missing: the load's torque is its weight times its lever arms, which only "
            "the arm's kinematics say. Name its description; the masses in it are not used"
        )
    same = {path.resolve() for path in unloaded} & {path.resolve() for path in loaded}
    if same:
        raise UserError(f"{same.pop()}: is named both without and with the load")


def _motions(
    paths: list[Path], arguments: Namespace, conditioning: "Conditioning", console: Console
) -> "list[Motion]":
    joints = options.names(arguments.joints)
    recordings = [sources.read(path, arguments.topic) for path in paths]
    if joints:
        recordings = [recording.select(joints) for recording in recordings]
    sources.require_same_joints(recordings)
    return [one.motion for one in sources.prepare(recordings, conditioning, console)]


def _scale(found: "DriveGains", conditioning: "Conditioning") -> dict[str, float]:
    """Return N·m per unit of the recorded effort, of joints whose gain is identified."""
    given = conditioning.effort_scale
    return {
        one.joint: one.gain.value * given.get(one.joint, 1.0) for one in found.each if one.known
    }


def _say(found: "DriveGains", conditioning: "Conditioning", console: Console) -> None:
    console.say(f"torque per unit of effort, from {found.blocks} blocks of 2 s")
    rows = []
    for one, error in zip(found.each, found.error, strict=True):
        scale = conditioning.effort_scale.get(one.joint, 1.0)
        numbers = (one.gain.value * scale, one.gain.low * scale, one.gain.high * scale)
        remark = "" if one.known else "not identified"
        cells = [*map(number, numbers), f"{one.share:.0%}", number(error), remark]
        rows.append([one.joint, *cells])
    header = ["joint", "N·m per unit", "5 %", "95 %", "due to the load", "left [N·m rms]", ""]
    console.say(table(header, rows))
    unknown = [one.joint for one in found.each if not one.known]
    if unknown:
        console.paragraph(
            f"not identified: {', '.join(unknown)}. The load adds too little torque there that "
            "differs from what the arm's own masses may do: use a heavier load, off the joint's "
            "axis, move the joint through more of its range, or give --payload-centre"
        )
    if found.left_out:
        console.note(
            f"left out, since they contradict the other blocks, as a contact does: "
            f"{', '.join(found.left_out)}"
        )
    centre = ", ".join(number(value) for value in found.centre)
    console.say(f"the load's centre of mass in the frame of the last joint: {centre} m")
