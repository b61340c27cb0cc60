"""`investigate`: a robot that does the motions which decide what its model lacks."""

from argparse import ArgumentParser, Namespace
from datetime import datetime
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangian_ff.cli.common import designed, investigating, options
from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.outputs import check_outputs, whole, write_record
from lagrangian_ff.errors import UserError
from lagrangian_ff.record_json import to_json

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lagrangian_ff.arrays import Floats
    from lagrangian_ff.diagnosis.excite.keeping import Clear
    from lagrangian_ff.investigation import Investigation, Permit, Plan, Rig

NAME = "investigate"
SUMMARY = "move a robot until it is decided what its model lacks"
USAGE = "--topic TOPIC (--urdf FILE | --limits FILE) [options]"
DESCRIPTION = """\
Closes the loop by itself: moves the arm within the limits that you give, identifies a model, finds
what it lacks, designs the motion that decides what is open, moves again, until nothing is open or
the time for motion is used. Formulas are proposed for what no known effect fits; one that unseen
motion confirms is added, and the model's file holds it. Where none does, it is taken in as a curve
in the end. It asks on the terminal before the first motion and before each larger range. Ctrl-C
stops the arm at once; what is known by then is written all the same. A touch that a running node
`monitor` reports stops the arm, too. With --simulate it moves the simulated arm, without ROS and
faster than real time."""
EPILOG = """\
examples:
  lagrangian_ff investigate --simulate quadratic_drag@joint_2:0.1 --report story.html
  lagrangian_ff investigate --topic /joint_trajectory_controller/joint_trajectory \\
      --urdf robot.urdf --floor 0 --output model.npz --report story.html
  lagrangian_ff investigate --topic /arm/joint_trajectory --limits joint_limits.yaml \\
      --minutes 6 --yes /arm/joint_trajectory

a file of limits (joints from base to tool, as MoveIt's joint_limits.yaml has them):
  joint_limits:
    shoulder: {min_position: -1.5, max_position: 1.5, max_velocity: 2.0, max_effort: 80}
    elbow: {min_position: 0.2, max_position: 2.0, max_velocity: 2.0, max_acceleration: 4.0}

On a real arm: keep the emergency stop in your hand. Motions begin and end where the arm stands when
the command starts. With --urdf links keep clear of each other and of --floor and --box; with
--limits alone nobody knows what touches."""


def add_arguments(parser: ArgumentParser) -> None:
    group = parser.add_argument_group("the arm")
    options.add_rows(group, (
        ("--topic", str, "TOPIC", "where it takes trajectory_msgs/JointTrajectory"),
        ("--joint-states", str, "TOPIC", "where it publishes joint states (default: joint_states)"),
        ("--joints", list, "JOINT",
         "joints to move, from base to tool (default: those of --limits or --urdf that the "
         "controller takes; without fingers)"),
        ("--simulate", list, "EFFECT@JOINT:SIZE",
         "move the simulated arm instead, and hide these in it, as simulate --hidden does; "
         "`nothing` hides nothing"),
        ("--yes", str, "TOPIC", "do not ask; only with the very name that --topic gives"),
    ))  # fmt: skip
    group = parser.add_argument_group("where it may go")
    designed.add_shapes(group)
    options.add_rows(group, (
        ("--limits", Path, "FILE.yaml", "limits by joint, see below"),
        ("--speed", float, "SHARE", "of the highest speeds that motions may take (default: 0.5)"),
        ("--until-fast", float, "SECONDS",
         "in which a joint may reach that speed, where no acceleration is given (default: 0.4)"),
    ))  # fmt: skip
    group = parser.add_argument_group("the investigation")
    gear = "the kind of gear of all joints, or JOINT=GEAR; what is usual in it is asked for first"
    options.add_rows(group, (
        ("--minutes", float, "MINUTES", "of motion, all in all (default: 4)"),
        ("--size", float, "SHARE",
         "of a joint's torque, from which on an effect should be seen (default: 0.02)"),
        ("--model", str, "KERNEL+EFFECTS", "to begin with (default: auto+fri)"),
        ("--gear", list, "GEAR", gear),
        ("--seed", int, "", "seed of the random numbers (default: 0)"),
    ))  # fmt: skip
    options.add_rows(parser, (
        ("--output", Path, "MODEL.npz", "the model with all that is confirmed"),
        ("--report", Path, "FILE.html", "the story on one page"),
        ("--formulas", Path, "MINE.json",
         "the formulas proposed for what no effect fits, for --effects-file"),
        ("--folder", Path, "FOLDER",
         "for motions and bags (default: investigation_ and the time, here)"),
    ))  # fmt: skip
    parser.set_defaults(seed=0, minutes=4.0, size=0.02, speed=0.5, until_fast=0.4, model="")
    options.add_conditioning(parser)
    options.add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    _check(arguments)
    options.load_own_effects(arguments, console)
    with investigating.interruptible() as stopping:
        if arguments.simulate:
            found, folder = _simulated(arguments, console, stopping), None
        else:
            found, folder = _robot(arguments, console, stopping)
    _write(found, arguments)
    investigating.say(found, console)
    formulas = arguments.formulas if found.unlisted else None
    saved = [arguments.output if found.model else None, arguments.report, formulas, folder]
    for path in filter(None, saved):
        console.say(f"saved: {path}")
    return investigating.INTERRUPTED if stopping.asked else 0


def _check(arguments: Namespace) -> None:
    check_outputs(arguments, [arguments.urdf, arguments.limits], ".npz")
    options.check_seed(arguments)
    designed.check_shapes(arguments)
    if not 0.15 <= arguments.minutes <= 60.0:
        raise UserError(f"--minutes {arguments.minutes:g}: expected 0.15 to 60")
    if not 0.0 < arguments.size < 1.0:
        raise UserError(f"--size {arguments.size:g}: expected a share between 0 and 1")
    robot = ["topic", "joint_states", "joints", "urdf", "limits", "yes", "folder"]
    given = [f"--{one.replace('_', '-')}" for one in robot if getattr(arguments, one)]
    if arguments.simulate:
        if given:
            raise UserError(f"{given[0]} is for a robot: leave it, or --simulate, out")
        if find_spec("pybullet") is None:
            raise UserError("the simulated arm needs PyBullet: pip install pybullet")
        return
    if arguments.topic is None:
        raise UserError("name the topic that moves the arm with --topic, or give --simulate")
    if arguments.urdf is None and arguments.limits is None:
        raise UserError("give --urdf or --limits: they say where the arm may go")
    if arguments.yes is not None and arguments.yes != arguments.topic:
        raise UserError(
            f"--yes {arguments.yes}: expected the very name of the topic, {arguments.topic}; "
            "nothing moves"
        )
    if arguments.folder and arguments.folder.is_dir() and any(arguments.folder.iterdir()):
        raise UserError(f"--folder {arguments.folder}: is not empty; name another one")


def _simulated(
    arguments: Namespace, console: Console, stopping: "investigating.Stopping"
) -> "Investigation":
    """Investigate the simulated arm."""
    from lagrangian_ff.arm.hiding import wanted
    from lagrangian_ff.cli.common.arm_motion import arm_clear
    from lagrangian_ff.cli.common.simulated_rig import SimulatedRig, simulated_limits
    from lagrangian_ff.diagnosis.excite.clearance import MARGIN
    from lagrangian_ff.investigation import Proposal, investigate

    asked = wanted([one for one in arguments.simulate if one != "nothing"])
    rig = SimulatedRig(asked, arguments.seed)

    def permit(proposal: Proposal) -> bool:
        investigating.say_proposal(proposal, console, "the simulated arm")
        return True

    with arm_clear(rig.joints, MARGIN) as clear:
        limits = simulated_limits(arguments.speed, arguments.until_fast)
        plan = _plan(arguments, rig, limits, clear)
        return investigate(rig, plan, permit, investigating.lines(console))


def _robot(
    arguments: Namespace, console: Console, stopping: "investigating.Stopping"
) -> "tuple[Investigation, Path]":
    """Investigate a robot in the graph."""
    from lagrangian_ff.diagnosis.excite.excite import inside
    from lagrangian_ff.investigation import investigate
    from lagrangian_ff.investigation.allowed import allowed
    from lagrangian_ff.nodes.attached.client import Client
    from lagrangian_ff.nodes.attached.rig import connected

    folder = arguments.folder or Path(f"investigation_{datetime.now():%Y%m%d_%H%M%S}")
    remap = f"joint_states:={arguments.joint_states}" if arguments.joint_states else ""
    client = Client(("--ros-args", "-r", remap) if remap else ())
    joints, files = options.names(arguments.joints), (arguments.urdf, arguments.limits)
    with connected(client, arguments.topic, joints, *files, folder) as rig:
        nodes = client.listeners(arguments.topic)
        limits = allowed(rig.joints, *files, arguments.speed, arguments.until_fast)
        start = rig.pose()
        inside("the pose of the arm", start, rig.joints, limits)
        clear = _clear(arguments, rig.joints, start, console)
        permit = _permit(arguments, nodes, clear is not None, console)
        stopping.rig = rig
        plan = _plan(arguments, rig, limits, clear)
        return investigate(rig, plan, permit, investigating.lines(console)), folder


def _plan(arguments: Namespace, rig: "Rig", limits: Any, clear: "Clear | None") -> "Plan":
    from lagrangian_ff.investigation import Plan

    return Plan(
        limits,
        budget=60.0 * arguments.minutes,
        size=arguments.size,
        model=arguments.model,
        conditioning=options.conditioning_of(arguments),
        clear=clear,
        gears=options.gears(arguments.gear, rig.joints),
        seed=arguments.seed,
    )


def _clear(
    arguments: Namespace, joints: "Sequence[str]", start: "Floats", console: Console
) -> "Clear | None":
    """Return what says whether a path touches anything; None, and a note, where nobody knows."""
    if arguments.urdf is None:
        return None
    if find_spec("pinocchio") is None:
        if arguments.box or arguments.floor is not None:
            raise UserError("--box and --floor need Pinocchio: pip install pin")
        console.note("Pinocchio is not there: whether links touch each other is not checked")
        return None
    try:
        return designed.clearance(arguments, joints, start[None])
    except UserError as error:
        if arguments.box or arguments.floor is not None:
            raise
        console.note(f"whether links touch each other is not checked: {error}")
        return None


def _permit(
    arguments: Namespace, nodes: "Sequence[str]", clear: bool, console: Console
) -> "Permit":
    """Return what asks on the terminal."""
    from lagrangian_ff.investigation import Proposal

    def permit(proposal: Proposal) -> bool:
        arm = f"{', '.join(nodes)} on {arguments.topic}"
        investigating.say_proposal(proposal, console, arm)
        if not clear:
            console.note("nobody checks whether the arm touches itself or what is near")
        if arguments.yes is not None:
            console.say(f"permitted by --yes {arguments.yes}")
            return True
        return investigating.ask()

    return permit


def _write(found: "Investigation", arguments: Namespace) -> None:
    from lagrangian_ff.report import investigation_page

    if arguments.output is not None and found.model is not None:
        with whole(arguments.output) as path:
            found.model.save(path)
    if arguments.report is not None:
        with whole(arguments.report) as path:
            investigation_page(path, found)
    if arguments.formulas is not None and found.unlisted is not None:
        with whole(arguments.formulas) as path:
            path.write_text(to_json({"effects": found.unlisted.effects}), encoding="utf-8")
    write_record(arguments.json, found.record())
