"""`layout`: what PlotJuggler and Foxglove show of a running robot."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.outputs import check_outputs, whole, write_record
from lagrangian_ff.errors import UserError

NAME = "layout"
SUMMARY = "write a layout of PlotJuggler or Foxglove with the torques of a robot's joints"
USAGE = "MODEL [options]"
DESCRIPTION = """\
Writes what PlotJuggler or Foxglove shall show of a running robot, for the joints of a model:
measured, predicted and feedforward torque, what is commanded, and the residual."""
EPILOG = """\
examples:
  lagrangian_ff layout model.npz --plotjuggler torque.xml
  ros2 run plotjuggler plotjuggler --layout torque.xml
  lagrangian_ff layout model.npz --foxglove torque.json --namespace left_arm

what comes out:
  PlotJuggler: a tab of torques and a tab of residuals, a plot for each joint; choose the topics in
  its streamer. Foxglove: a row for each joint, torques beside residual, to import as a layout.
  The nodes monitor and feedforward publish what is shown."""


def add_arguments(parser: ArgumentParser) -> None:
    options.add_model(parser, "a model file, whose joints are shown")
    options.add_rows(parser, (
        ("--plotjuggler", Path, "FILE.xml", "write a layout of PlotJuggler"),
        ("--foxglove", Path, "FILE.json", "write a layout of Foxglove"),
        ("--namespace", str, "NS", "namespace of the robot (default: none)"),
    ))  # fmt: skip
    options.add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    wanted = {"plotjuggler": arguments.plotjuggler, "foxglove": arguments.foxglove}
    if not any(wanted.values()):
        raise UserError("name what to write: --plotjuggler FILE.xml, --foxglove FILE.json, or both")
    check_outputs(arguments, [arguments.model])
    options.load_own_effects(arguments, console)
    from lagrangian_ff.identification import Model
    from lagrangian_ff.report import layouts

    joints = Model.load(arguments.model).joints
    made = {}
    for name, path in wanted.items():
        if path is not None:
            text = getattr(layouts, name)(joints, arguments.namespace or "")
            with whole(path) as file:
                file.write_text(text, encoding="utf-8")
            made[name] = str(path)
            console.say(f"saved: {path}, {name} with {', '.join(joints)}")
    write_record(arguments.json, {"joints": list(joints), **made})
    return 0
