"""`export`: a model in a form that controllers, simulators and descriptions of robots take."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console, table
from lagrangian_ff.cli.common.outputs import check_outputs, whole, write_record
from lagrangian_ff.errors import UserError

if TYPE_CHECKING:
    from lagrangian_ff.export.result import Exported

NAME = "export"
SUMMARY = "take a model away: C, JSON, ONNX, URDF, MJCF, a program of UR"
USAGE = "MODEL --to FORMAT --output PATH [options]"
DESCRIPTION = """\
Writes a model in a form that another program runs. c, json and onnx hold the model exactly; urdf,
mjcf and ur hold what bodies, friction and a payload can say of it. What a format does not hold is
said, with what that costs in N·m on the recording that the model was learned from."""
EPILOG = """\
examples:
  lagrangian_ff export model.npz --to c --output arm_model
  lagrangian_ff export model.npz --to json --output arm_model.json
  lagrangian_ff export model.npz --to urdf --urdf robot.urdf --output better.urdf

what comes out:
  c: a folder with a C99 library without dependencies, a CMake package and a pkg-config file;
  json: numbers, formulas and states to check with, by the schema in docs/export.md;
  then, by joint, the error in N·m (rms) of the model and of what was written against the measured
  torque, and what was lost. docs/export.md compares the formats."""


def add_arguments(parser: ArgumentParser) -> None:
    options.add_model(parser)
    options.add_rows(parser, (
        ("--to", str, "FORMAT", "c, json, onnx, urdf, mjcf or ur"),
        ("--output", Path, "PATH", "the file, or for c the folder, to write"),
    ), required=True)  # fmt: skip
    options.add_rows(parser, (
        ("--settled", bool, "", "leave effects of the past, of time and of temperature as they are "
         "after a long steady motion; without it, a model with such effects is refused"),
        ("--urdf", Path, "ROBOT.urdf", "the robot's description: for urdf, mjcf and ur"),
        ("--earlier", Path, "MODEL", "for ur: a model of the same arm whose friction the "
         "controller's own stands for"),
        ("--flange", str, "LINK", "for ur: the link that the tool is fastened to (default: tool0)"),
    ))  # fmt: skip
    options.add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    from lagrangian_ff.export import FORMATS, Options, write

    if arguments.to not in FORMATS:
        raise UserError(f"--to {arguments.to}: expected one of {', '.join(FORMATS)}")
    reads = [arguments.model, arguments.urdf, arguments.earlier]
    suffix = FORMATS[arguments.to].SUFFIX
    check_outputs(arguments, reads, suffix, folder="" if suffix else "library")
    options.load_own_effects(arguments, console)
    from lagrangian_ff.identification import Model

    model = Model.load(arguments.model)
    chosen = Options(
        settled=arguments.settled,
        urdf=arguments.urdf,
        earlier=Model.load(arguments.earlier) if arguments.earlier else None,
        **({"flange": arguments.flange} if arguments.flange else {}),
    )
    with whole(arguments.output) as path:
        found = write(model, arguments.to, path, chosen)
    write_record(arguments.json, {"model": str(arguments.model), **found.record()})
    _say(found, arguments.output, console)
    return 0


def _say(found: "Exported", path: Path, console: Console) -> None:
    """Say what was written, its error, and what was lost."""
    console.say(f"saved: {path}, {found.format} of {', '.join(found.joints)}")
    columns = found.model_error, found.error, found.difference
    rows = [[joint, *(f"{one[n]:.3g}" for one in columns)] for n, joint in enumerate(found.joints)]
    console.say(["", "error in N·m (rms) on the recording that the model was learned from"])
    console.say(table(["joint", "model", "exported", "difference"], rows))
    if found.losses:
        console.say(["", "what the format does not hold, N·m (rms) by joint"])
    for loss in found.losses:
        lost = ", ".join(f"{one:.3g}" for one in loss.rms)
        console.bullet(f"{loss.what}: {lost}")
    for note in found.notes:
        console.note(note)
