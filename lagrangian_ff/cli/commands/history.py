"""`history`: how a model came to be what it is."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.options import add_force, add_json
from lagrangian_ff.cli.common.outputs import check_file, whole, write_record
from lagrangian_ff.cli.common.own_effects import add_effects_file, load_own_effects
from lagrangian_ff.cli.text.history import say_history

NAME = "history"
SUMMARY = "tell what was added to a model, why, and what it did to the error"
USAGE = "MODEL [options]"
DESCRIPTION = """\
Tells the steps that made a model: how it was identified, and every effect that was added since,
with the reason and the error before and after on data held out."""
EPILOG = """\
examples:
  lagrangian_ff history model.npz
  lagrangian_ff history model.npz --report history.html --json -

what comes out:
  one line a step: what was added, when, on what verdict, the error before and after;
  the error of each joint after each step; why each step was made."""


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("model", type=Path, metavar="MODEL", help="a model file")
    parser.add_argument(
        "--report", type=Path, metavar="FILE.html", help="write a page with interactive figures"
    )
    add_effects_file(parser)
    add_json(parser)
    add_force(parser)


def run(arguments: Namespace) -> int:
    """See `Command`."""
    console = Console(arguments.json)
    _check_outputs(arguments)
    load_own_effects(arguments, console)
    from lagrangian_ff.identification import Model

    model = Model.load(arguments.model)
    record = {
        "model": str(arguments.model),
        "model_name": model.name,
        "steps": [dict(step) for step in model.steps],
    }
    if arguments.report is not None:
        from lagrangian_ff.report import history_page

        with whole(arguments.report) as path:
            history_page(path, record)
    write_record(arguments.json, record)
    console.say(f"{arguments.model}: {model.name}")
    say_history(record, console)
    if arguments.report is not None:
        console.say(["", f"saved: {arguments.report}"])
    return 0


def _check_outputs(arguments: Namespace) -> None:
    keep = [arguments.model]
    if arguments.report is not None:
        check_file(arguments.report, "--report", force=arguments.force, suffix=".html", keep=keep)
        keep.append(arguments.report)
    if arguments.json not in (None, "-"):
        check_file(Path(arguments.json), "--json", force=arguments.force, keep=keep)
