"""`feedforward`: the torque that a trajectory needs."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console, table
from lagrangian_ff.cli.common.outputs import check_outputs, write_record, write_table
from lagrangian_ff.cli.common.sources import out_of_range, warn_of_curves
from lagrangian_ff.cli.text.model import scaling
from lagrangian_ff.errors import UserError
from lagrangian_ff.numbers import number

if TYPE_CHECKING:
    from lagrangian_ff.arm import Trajectory
    from lagrangian_ff.arrays import Floats
    from lagrangian_ff.identification import Model, Terms


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

This is not a safety function: the controller that takes the torque must have its own limits."""


def add_arguments(parser: ArgumentParser) -> None:
    options.add_model(parser)
    text = "the motion, see below"
    parser.add_argument("trajectory", type=Path, metavar="TRAJECTORY.csv", help=text)
    options.add_rows(parser, [("--output", Path, "TORQUE.csv", "the CSV to write")], required=True)
    text = (
        "leave out parts of the torque: gravity, inertia, coriolis, friction, each with the "
        "effects that go with it (docs/nodes.md), or an effect by its name, such as coulomb"
    )
    options.add_list(parser, "--without", "PART", text)
    options.add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    check_outputs(arguments, [arguments.model, arguments.trajectory], ".csv")
    options.load_own_effects(arguments, console)
    from lagrangian_ff.arm import read_trajectory
    from lagrangian_ff.identification import Model

    model = Model.load(arguments.model)
    trajectory = _of_model(read_trajectory(arguments.trajectory), model, arguments, console)
    states = trajectory.q, trajectory.qd, trajectory.qdd
    without = options.names(arguments.without)
    torque = _without(model.terms(*states), without)
    parts = dict(zip(("position", "velocity", "acceleration"), states, strict=True))
    parts["effort"] = torque
    write_table(arguments.output, trajectory.time, parts, trajectory.joints)
    away = out_of_range(model, trajectory.time, states)
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
    console.say(scaling(model.identified.conditioning))
    console.say(_table(model, torque))
    then = "There the model guesses: stay inside, or identify from a motion that goes there"
    away.warn("trajectory", "the model", f": {away.when()}. {then}", console)
    warn_of_curves(model, trajectory.time, states, "trajectory", console)
    console.say(f"saved: {arguments.output}")
    return 0


def _of_model(
    trajectory: "Trajectory", model: "Model", arguments: Namespace, console: Console
) -> "Trajectory":
    """Return the trajectory of the model's joints.

    Raises:
        ModelError: the trajectory lacks one; names both lists.
    """
    model.require_joints(trajectory.joints, arguments.trajectory, arguments.model)
    for note in trajectory.notes:
        console.note(note)
    extra = [name for name in trajectory.joints if name not in model.joints]
    if extra:
        console.note(f"{', '.join(extra)}: not in the model, left out")
    return trajectory.select(model.joints)


def _without(terms: "Terms", without: tuple[str, ...]) -> "Floats":
    """Return the torque less some of its parts; raise UserError if there is no such part."""
    from lagrangian_ff.effects import effect_of
    from lagrangian_ff.identification.predicting import by_part

    parts = by_part(terms)
    unknown = [name for name in without if name not in parts and name not in terms.effects]
    if unknown:
        raise UserError(
            f"--without {', '.join(unknown)}: the torque of this model has the parts "
            f"{', '.join(parts)}, and of its effects {', '.join(terms.effects) or 'none'}"
        )
    torque = 0.0 * terms.gravity
    for name, values in parts.items():
        if name not in without:
            torque = torque + values
    for name in terms.effects:
        effect = effect_of(name)
        if name in without and effect is not None and effect.part not in without:
            torque = torque - terms.effects[name]
    return torque


def _table(model: "Model", torque: "Floats") -> list[str]:
    rows = []
    for n, name in enumerate(model.joints):
        largest, known = float(abs(torque[:, n]).max()), float(model.range.tau_max[n])
        mean = float((torque[:, n] ** 2).mean() ** 0.5)
        remark = "more than was ever measured" if largest > 1.1 * known else ""
        rows.append([name, number(mean), number(largest), number(known), remark])
    return table(["joint", "rms [N·m]", "largest [N·m]", "when identified [N·m]", ""], rows)
