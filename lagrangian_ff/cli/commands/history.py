"""`history`: how a model came to be what it is."""

from argparse import ArgumentParser, Namespace

from lagrangian_ff import report
from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.outputs import check_outputs, whole, write_record
from lagrangian_ff.cli.text.history import say_history

NAME = "history"
SUMMARY = "show what was added to a model, why, and what it did to the error"
USAGE = "MODEL [options]"
DESCRIPTION = """\
Shows the steps that made a model: how it was identified, and every effect that was added since,
with the reason and the error before and after on data held out."""
EPILOG = """\
examples:
  lagrangian_ff history model.npz
  lagrangian_ff history model.npz --report history.html --json -

what comes out:
  one line a step: what was added, when, on what verdict, the error before and after;
  the error of each joint after each step; why each step was made."""


def add_arguments(parser: ArgumentParser) -> None:
    options.add_model(parser, "a model file")
    options.add_report(parser)
    options.add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    check_outputs(arguments, [arguments.model])
    options.load_own_effects(arguments, console)
    from lagrangian_ff.identification import Model
    from lagrangian_ff.identification.history import History

    model = Model.load(arguments.model)
    found = History(str(arguments.model), model.name, model.history)
    if arguments.report is not None:
        with whole(arguments.report) as path:
            report.history_page(path, found)
    write_record(arguments.json, found.record())
    console.say(f"{found.file}: {found.model}")
    say_history(found.steps, console)
    if arguments.report is not None:
        console.say(["", f"saved: {arguments.report}"])
    return 0
