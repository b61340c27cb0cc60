"""`study`: how well the diagnosis finds effects that were hidden in the simulated arm."""

import json
from argparse import ArgumentParser, Namespace
from importlib.util import find_spec
from pathlib import Path

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.options import add_force, add_json
from lagrangian_ff.cli.common.outputs import check_file, write_record
from lagrangian_ff.cli.common.progress import progress_bar
from lagrangian_ff.errors import UserError

NAME = "study"
SUMMARY = "hide effects in the simulated arm and see whether they are found"
USAGE = "hidden --output FOLDER [options]"
DESCRIPTION = """\
`study hidden` hides one physical effect, two, or none in the physics of the simulated arm, on
several joints and at several sizes (RMS of its torque over RMS of the joint's), records the arm
twice, identifies a base model, has the recordings diagnosed, and judges what was said."""
EPILOG = """\
examples:
  lagrangian_ff study hidden --output hidden --jobs 2     hours: about a minute a case
  lagrangian_ff study hidden --output try --small         ten minutes: a few large effects
  lagrangian_ff study hidden --output hidden --list       the names of the cases, nothing done
  lagrangian_ff study hidden --output hidden --cases 'ripple-*'

what comes out:
  for each size how often the diagnosis is right, right as a class of effects that look the same,
  wrong, or confirms nothing; what it confirms on arms without anything hidden and with what no
  catalogue has; and the error on unseen motion after adding what was confirmed, over that of a
  model given the true effect. In the folder: cases.jsonl with everything about each case,
  summary.json, and hidden.png.

Interrupt it with Ctrl-C; the same command goes on where it was."""


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("study", choices=("hidden",), help="which study")
    parser.add_argument(
        "--output", required=True, type=Path, metavar="FOLDER", help="made where it is missing"
    )
    parser.add_argument("--small", action="store_true", help="a few cases only")
    parser.add_argument(
        "--seed", type=int, default=0, help="of all that chance decides (default 0)"
    )
    parser.add_argument(
        "--jobs", type=int, default=1, metavar="N", help="processes of one thread (default: 1)"
    )
    parser.add_argument(
        "--cases", default="*", metavar="PATTERN", help="only those named so, with * and ?"
    )
    parser.add_argument(
        "--keep", action="store_true", help="keep the recordings, and use those that are there"
    )
    parser.add_argument("--list", action="store_true", help="only name the cases")
    add_json(parser)
    add_force(parser)


def run(arguments: Namespace) -> int:
    """See `Command`."""
    console = Console(arguments.json)
    if find_spec("pybullet") is None:
        raise UserError("the simulated arm needs PyBullet: pip install pybullet")
    if arguments.seed < 0:
        raise UserError(f"--seed {arguments.seed}: expected a whole number from 0 up")
    if arguments.json not in (None, "-"):
        check_file(Path(arguments.json), "--json", force=arguments.force)
    from lagrangian_ff.studies.hidden.run import Options, run

    options = Options(
        arguments.output,
        arguments.seed,
        small=arguments.small,
        only=arguments.cases,
        jobs=arguments.jobs,
        keep=arguments.keep,
    )
    if arguments.list:
        console.say(case.name for case in options.cases())
        return 0
    from lagrangian_ff.report.style import png
    from lagrangian_ff.studies.hidden.examiner import Diagnosis
    from lagrangian_ff.studies.hidden.figure import figure
    from lagrangian_ff.studies.hidden.store import Folder
    from lagrangian_ff.studies.hidden.table import ratios_by_size, summary, table

    with progress_bar("study") as progress:
        lines = run(options, Diagnosis(), progress)
    numbers = summary(lines)
    folder = Folder(options.output)
    folder.summary.write_text(json.dumps(numbers, indent=1), encoding="utf-8")
    folder.picture.write_bytes(png(figure(numbers, ratios_by_size(lines))))
    write_record(arguments.json, numbers)
    console.say(table(numbers))
    console.say(f"saved: {folder.lines}, {folder.summary}, {folder.picture}")
    return 0
