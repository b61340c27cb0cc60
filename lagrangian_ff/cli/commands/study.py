"""`study`: the studies behind what this project claims, each repeated with one command."""

import json
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.options import add_force, add_json, check_seed, names
from lagrangian_ff.cli.common.outputs import check_file, write_record
from lagrangian_ff.cli.common.progress import progress_bar
from lagrangian_ff.studies.catalogue import STUDIES, study_class

if TYPE_CHECKING:
    from lagrangian_ff.studies.common.workers import Workers

NAME = "study"
SUMMARY = "repeat a study: the paper's figures, and effects hidden in the simulated arm"
USAGE = "NAME [--output FOLDER] [options]"
DESCRIPTION = "Repeats a study, with a table, a picture and every result as JSON:\n\n" + "\n".join(
    f"  {name:<12} {entry.about}" for name, entry in STUDIES.items()
)
EPILOG = """\
examples:
  lagrangian_ff study ideal                      16 robots of 1 to 8 joints each
  lagrangian_ff study ideal --robots 100         as many as in the paper
  lagrangian_ff study ideal --quick              a minute: a small study, to see it work
  lagrangian_ff study hidden --list              the names of the cases, nothing done
  lagrangian_ff study hidden --cases 'ripple-*'  some of them
  lagrangian_ff study ideal --scheduler tcp://host:8786   on the workers of a Dask cluster

how long it takes, on two processors, about:
  hidden 3 h; ideal and friction 1 h; speeds 20 minutes; loaded, tracking, sparsity and consistency
  5 to 10 minutes.

what comes out, in the folder:
  cases.jsonl (every case, a line each, as it is done), summary.json (the numbers of the table), and
  the picture, named after the study.

Interrupt it with Ctrl-C; the same command goes on where it was."""


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("study", metavar="NAME", help=", ".join(STUDIES))
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FOLDER",
        help="default: study_NAME; made where it is missing",
    )
    parser.add_argument(
        "--quick", "--small", action="store_true", help="a small study, to see it work"
    )
    parser.add_argument(
        "--seed", type=int, default=0, help="of all that chance decides (default 0)"
    )
    parser.add_argument(
        "--robots", type=int, metavar="N", help="how many random robots of each kind"
    )
    parser.add_argument(
        "--models",
        nargs="+",
        default=[],
        metavar="MODEL",
        help="only these, as in vrbfs or motor+fri",
    )
    parser.add_argument(
        "--cases", default="*", metavar="PATTERN", help="only those named so, with * and ?"
    )
    parser.add_argument("--list", action="store_true", help="only name the cases")
    parser.add_argument(
        "--keep", action="store_true", help="keep the recordings, and use those that are there"
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--jobs", type=int, metavar="N", help="processes of one thread (default: the processors)"
    )
    where.add_argument(
        "--scheduler", metavar="ADDRESS", help="of a Dask cluster that does the work"
    )
    add_json(parser)
    add_force(parser)


def run(arguments: Namespace) -> int:
    """See `Command`."""
    console = Console(arguments.json)
    check_seed(arguments)
    if arguments.json not in (None, "-"):
        check_file(Path(arguments.json), "--json", force=arguments.force)
    kind = study_class(arguments.study)
    from lagrangian_ff.report.style import png
    from lagrangian_ff.studies.common.folder import Folder
    from lagrangian_ff.studies.common.run import run as run_study
    from lagrangian_ff.studies.common.study import Request

    output: Path = arguments.output or Path(f"study_{arguments.study}")
    request = Request(
        seed=arguments.seed,
        quick=arguments.quick,
        only=arguments.cases,
        robots=arguments.robots,
        models=names(arguments.models),
        keep=arguments.keep,
    )
    study = kind(request, output)
    if arguments.list:
        console.say(case.name for case in study.cases())
        return 0
    workers = _workers(arguments)
    with progress_bar(f"study {study.name}") as progress:
        lines = run_study(study, output, workers, progress)
    numbers = study.numbers(lines)
    folder = Folder(output, study.name)
    folder.summary.write_text(json.dumps(numbers, indent=1), encoding="utf-8")
    folder.picture.write_bytes(png(study.figure(numbers)))
    write_record(arguments.json, numbers)
    console.say(study.table(numbers))
    console.say(f"saved: {folder.lines}, {folder.summary}, {folder.picture}")
    return 0


def _workers(arguments: Namespace) -> "Workers":
    from lagrangian_ff.studies.common.workers import cluster, processes

    if arguments.scheduler is not None:
        return cluster(arguments.scheduler)
    return processes(arguments.jobs)
