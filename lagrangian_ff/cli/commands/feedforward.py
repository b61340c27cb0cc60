"""`feedforward`: the torque a trajectory needs."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.leaving import leaving
from lagrangian_ff.cli.common.options import add_force, add_json, names
from lagrangian_ff.cli.common.outputs import check_file, write_record, write_table
from lagrangian_ff.cli.common.own_effects import add_effects_file, load_own_effects
from lagrangian_ff.cli.text.layout import number, table
from lagrangian_ff.errors import UserError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from lagrangian_ff.arm import Trajectory
    from lagrangian_ff.identification import Model, Terms

    Floats = NDArray[np.float64]

NAME = "feedforward"
SUMMARY = "compute the torque along a trajectory"
USAGE = "MODEL TRAJECTORY.csv --output TORQUE.csv [options]"
DESCRIPTION = """\
Computes the torque that a trajectory needs, offline (precomputed torque), and writes it as CSV.
Joints are matched by name; the trajectory may hold more joints than the model, in any order."""
EPILOG = """\
examples:
  lagrangian_ff feedforward model.npz trajectory.csv --output torque.csv
  lagrangian_ff feedforward model.npz trajectory.csv --output torque.csv --without gravity
                                    for a robot whose controller already compensates gravity

the trajectory: a CSV with the header time,position/<joint>,velocity/<joint>,acceleration/<joint>
  in s, rad, rad/s, rad/s²; velocity and acceleration may be left out, they are then those of a
  quintic spline through the positions. `lagrangian_ff simulate --save-trajectory` writes one.
what comes out:
  the same CSV with the columns effort/<joint> in N·m, and a note where the trajectory leaves the
  positions, velocities or accelerations that the model was identified on: there it guesses.

This is not a safety function: the controller that takes the torque must have limits of its own."""

PARTS = ("gravity", "inertia", "coriolis")


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("model", type=Path, metavar="MODEL", help="a model file of identify")
    parser.add_argument(
        "trajectory", type=Path, metavar="TRAJECTORY.csv", help="the motion, see below"
    )
    parser.add_argument(
        "--output", required=True, type=Path, metavar="TORQUE.csv", help="the CSV to write"
    )
    parser.add_argument(
        "--without",
        nargs="+",
        action="extend",
        default=[],
        metavar="PART",
        help="leave out parts of the torque: gravity, inertia, coriolis, friction (all effects), "
        "or an effect by its name, such as coulomb",
    )
    add_effects_file(parser)
    add_json(parser)
    add_force(parser)


def run(arguments: Namespace) -> int:
    """See `Command`."""
    console = Console(arguments.json)
    inputs = [arguments.model, arguments.trajectory]
    check_file(arguments.output, "--output", force=arguments.force, suffix=".csv", keep=inputs)
    if arguments.json not in (None, "-"):
        keep = [*inputs, arguments.output]
        check_file(Path(arguments.json), "--json", force=arguments.force, keep=keep)
    load_own_effects(arguments, console)
    from lagrangian_ff.arm import read_trajectory
    from lagrangian_ff.identification import Model

    model = Model.load(arguments.model)
    trajectory = _of_model(read_trajectory(arguments.trajectory), model, arguments, console)
    states = trajectory.q, trajectory.qd, trajectory.qdd
    without = names(arguments.without)
    torque = _without(model.terms(*states), without)
    write_table(arguments.output, _columns(trajectory, torque))
    away = leaving(model, trajectory.time, states)
    write_record(
        arguments.json,
        {
            "model": str(arguments.model),
            "trajectory": str(arguments.trajectory),
            "without": list(without),
            "outside_range": away.share,
            "outside_spans": [list(span) for span in away.spans],
            "joints": {
                name: {"largest": float(abs(torque[:, n]).max())}
                for n, name in enumerate(model.joints)
            },
        },
    )
    console.say(
        f"torque of {len(trajectory)} points in {trajectory.duration:.3f} s"
        + (f", without {', '.join(without)}" if without else "")
    )
    console.say(_table(model, torque))
    if away.share > 0.0:
        console.note(
            f"{away.share:.1%} of the trajectory lies outside what the model was identified on "
            f"({away.worst}): {away.when()}. There the model guesses: stay inside, or identify "
            "from a motion that goes there",
            "",
        )
    console.say(f"saved: {arguments.output}")
    return 0


def _of_model(
    trajectory: "Trajectory", model: "Model", arguments: Namespace, console: Console
) -> "Trajectory":
    """The joints of the model.

    Raises:
        ModelError: the trajectory lacks one; names both lists.
    """
    model.require_joints(trajectory.joints, arguments.trajectory, arguments.model)
    for note in trajectory.notes:
        console.note(note, "")
    extra = [name for name in trajectory.joints if name not in model.joints]
    if extra:
        console.note(f"{', '.join(extra)}: not in the model, left out", "")
    return trajectory.select(model.joints)


def _without(terms: "Terms", without: tuple[str, ...]) -> "Floats":
    """The torque less some of its parts.

    Raises:
        UserError: there is no such part.
    """
    parts = {name: getattr(terms, name) for name in PARTS} | dict(terms.effects)
    unknown = [name for name in without if name not in parts and name != "friction"]
    if unknown:
        raise UserError(
            f"--without {', '.join(unknown)}: the torque of this model has the parts "
            f"{', '.join(parts)}; friction stands for all of "
            f"{', '.join(terms.effects) or 'its effects (it has none)'}"
        )
    left = {*without, *(terms.effects if "friction" in without else ())}
    torque = 0.0 * terms.gravity
    for name, values in parts.items():
        if name not in left:
            torque = torque + values
    return torque


def _columns(trajectory: "Trajectory", torque: "Floats") -> "dict[str, Floats]":
    columns = {"time": trajectory.time}
    for label, values in (
        ("position", trajectory.q),
        ("velocity", trajectory.qd),
        ("acceleration", trajectory.qdd),
        ("effort", torque),
    ):
        columns |= {f"{label}/{name}": values[:, n] for n, name in enumerate(trajectory.joints)}
    return columns


def _table(model: "Model", torque: "Floats") -> list[str]:
    rows = []
    for n, name in enumerate(model.joints):
        largest, known = float(abs(torque[:, n]).max()), float(model.range.tau_max[n])
        mean = float((torque[:, n] ** 2).mean() ** 0.5)
        remark = "more than was ever measured" if largest > 1.1 * known else ""
        rows.append([name, number(mean), number(largest), number(known), remark])
    return table(["joint", "rms [N·m]", "largest [N·m]", "when identified [N·m]", ""], rows)
