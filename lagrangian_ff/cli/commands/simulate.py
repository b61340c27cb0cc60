"""`simulate`: a motion of the simulated arm without ROS, recorded as a bag."""

from argparse import ArgumentParser, Namespace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console, progress_bar, table
from lagrangian_ff.cli.common.outputs import check_outputs, whole, write_record
from lagrangian_ff.errors import ArmError, UserError
from lagrangian_ff.numbers import number

if TYPE_CHECKING:
    from lagrangian_ff.arm import Run
    from lagrangian_ff.arm.hiding import Hidden

NAME = "simulate"
SUMMARY = "drive the simulated arm without ROS and write a bag"
USAGE = "--output BAG [options]"
DESCRIPTION = """\
Drives the simulated 6-joint arm (PyBullet) along a trajectory, with or without feedforward
torque, writes what its driver would report as a rosbag2 folder, and says how well it tracked."""
EPILOG = """\
examples:
  lagrangian_ff simulate --output bag                     an exciting motion, to learn from
  lagrangian_ff simulate --seed 1 --save-trajectory t.csv --output before
  lagrangian_ff simulate --trajectory t.csv --feedforward model.npz --output after
  lagrangian_ff simulate --feedforward torque.csv --output after    with what `feedforward` wrote
  lagrangian_ff simulate --loads joint_1=2.5 joint_2=1 --output loaded
  lagrangian_ff simulate --hidden stribeck@joint_3:0.1 --output odd     for diagnose to find

what comes out:
  the bag, with joint_states at 500 Hz;
  the tracking error of each joint in mrad, reference less measured position. With
  --feedforward true the arm gets its own true torques: no model can do better."""


CLOSE = 0.05
"""An effect that misses its wanted size by no more than this share has it."""


def add_arguments(parser: ArgumentParser) -> None:
    options.add_rows(parser, [("--output", Path, "BAG", "the bag folder to write")], required=True)
    group = parser.add_argument_group("the motion")
    speed = "speed of an exciting trajectory through the workspace (default: 5)"
    group.add_argument("--speed", type=int, choices=range(1, 11), metavar="1..10", help=speed)
    options.add_rows(
        group,
        [
            ("--seed", int, "", "seed of that trajectory and of the sensors' noise (default: 0)"),
            ("--duration", float, "SECONDS", "length of that trajectory (default: 30 to 40)"),
            ("--trajectory", Path, "FILE.csv", "drive this one instead"),
            ("--save-trajectory", Path, "FILE.csv", "write the reference as CSV"),
        ],
    )
    group = parser.add_argument_group("the arm")
    options.add_rows(group, (
        ("--loads", list, "JOINT=KG",
         "masses on the links that these joints move, or `paper` for 2.5 kg and 1 kg on the first "
         "two"),
        ("--hidden", list, "EFFECT@JOINT:SIZE",
         "physics that the arm's description does not mention, such as stribeck@joint_3:0.1; "
         "SIZE is its torque (rms) over that of the joint"),
        ("--feedforward", str, "none|true|MODEL.npz|TORQUE.csv",
         "torque added to the position loop: none, the arm's own true torque, that of a model, or "
         "that of a CSV of the command feedforward (default: none)"),
    ))  # fmt: skip
    parser.set_defaults(seed=0, feedforward="none")
    options.add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    _check_arguments(arguments)
    from lagrangian_ff.arm import PAPER_LOADS, simulate, write_trajectory
    from lagrangian_ff.arm.hiding import hidden, wanted
    from lagrangian_ff.cli.common import simulated
    from lagrangian_ff.recording import write_bag

    paper = arguments.loads == ["paper"]
    given = {} if paper else options.assignments("--loads", arguments.loads)
    asked = wanted(arguments.hidden)
    options.load_own_effects(arguments, console)
    source = simulated.motion_file(arguments)
    trajectory = simulated.motion_of(source, arguments, console)
    feedforward = simulated.torque_of(arguments.feedforward, trajectory, console)
    with progress_bar("sizing what is hidden") as progress:
        inside = hidden(asked, arguments.seed, progress)
    with progress_bar("simulating") as progress:
        try:
            done = simulate(
                trajectory,
                feedforward,
                loads=PAPER_LOADS if paper else given,
                **inside.arm,
                seed=arguments.seed,
                progress=progress,
            )
        except ArmError as error:
            raise ArmError(f"{source}: {error}" if source else str(error)) from error
    with whole(arguments.output) as path, progress_bar("writing") as progress:
        write_bag(path, done.recording, progress=progress)
    if arguments.save_trajectory is not None:
        with whole(arguments.save_trajectory) as path:
            write_trajectory(path, trajectory)
    record = _record(done, inside, arguments)
    write_record(arguments.json, record)
    _say(record, arguments, console)
    return 0


def _check_arguments(arguments: Namespace) -> None:
    options.check_seed(arguments)
    inputs = [] if arguments.trajectory is None else [arguments.trajectory]
    if arguments.feedforward not in ("none", "true"):
        path = Path(arguments.feedforward)
        if path.suffix not in (".npz", ".csv"):
            raise UserError(
                f"--feedforward {path}: expected none, true, a model (.npz) or a torque (.csv)"
            )
        if not path.is_file():
            raise UserError(f"--feedforward {path}: no such file")
        inputs.append(path)
    check_outputs(arguments, inputs, folder="bag")
    made = [f"--{name}" for name in ("speed", "duration") if getattr(arguments, name) is not None]
    if arguments.trajectory is not None and made:
        raise UserError(f"--trajectory names the motion; {' and '.join(made)} would make another")
    if find_spec("pybullet") is None:
        raise UserError("the simulated arm needs PyBullet: pip install pybullet")


def _record(done: "Run", inside: "Hidden", arguments: Namespace) -> dict[str, Any]:
    error = done.tracking_error
    return {
        "bag": str(arguments.output),
        "feedforward": arguments.feedforward,
        "seed": arguments.seed,
        "hidden": list(inside.records),
        "seconds": float(done.recording.time[-1]),
        **_sizes(error),
        "joints": {
            name: {**_sizes(error[:, n]), "saturated": float(done.saturated[:, n].mean())}
            for n, name in enumerate(done.recording.joints)
        },
        "unit": "rad",
    }


def _sizes(error: Any) -> dict[str, float]:
    return {"rms": float((error**2).mean() ** 0.5), "largest": float(abs(error).max())}


def _in_words(hidden: dict[str, Any]) -> str:
    text = (
        f"hidden in the arm: {hidden['physics']} ({hidden['effect']} on {hidden['joint']}), "
        f"{hidden['size']:.1%} of the joint's torque"
    )
    less = hidden["size"] < (1.0 - CLOSE) * hidden["wanted"]
    return f"{text}, as much as this physics can make" if less else text


def _say(record: dict[str, Any], arguments: Namespace, console: Console) -> None:
    console.say(
        f"drove {record['seconds']:.1f} s, feedforward: {arguments.feedforward}; "
        "tracking error, reference less measured position"
    )
    for found in record["hidden"]:
        console.paragraph(_in_words(found))
    rows = []
    for name, one in [*record["joints"].items(), ("all joints", record)]:
        share = one.get("saturated", 0.0)
        cut = f"torque cut at its limit for {share:.1%} of the time" if share > 0.0 else ""
        rows.append([name, number(1e3 * one["rms"]), number(1e3 * one["largest"]), cut])
    console.say(table(["joint", "rms [mrad]", "largest [mrad]", ""], rows))
    console.say(f"saved: {arguments.output}")
    if arguments.save_trajectory is not None:
        console.say(f"saved: {arguments.save_trajectory}")
    if arguments.feedforward == "none":
        console.say(
            f"next: lagrangian_ff identify {arguments.output} --train 1.0 --output model.npz"
        )
