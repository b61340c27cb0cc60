"""`study`: the studies behind what this project claims, each repeated with one command."""

import json
from argparse import ArgumentParser, Namespace
from pathlib import Path

from lagrangian_ff.cli.common.claims import claim
from lagrangian_ff.cli.common.console import Console, progress_bar
from lagrangian_ff.cli.common.options import add_common, add_rows, check_seed, names
from lagrangian_ff.cli.common.outputs import check_file, write_record
from lagrangian_ff.studies.catalogue import STUDIES, study_class

NAME = "study"
SUMMARY = "repeat a study: the paper's figures, hidden effects, measured recordings"
USAGE = "NAME [RECORDINGS] [--output FOLDER] [options]"
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
  lagrangian_ff study nuisances --record         its recordings alone, to be judged with --keep
  lagrangian_ff study measured FOLDER            arms whose recordings are in a folder
  lagrangian_ff study measured FOLDER --known config/measured --only ur10   one of them
  lagrangian_ff study ideal --scheduler tcp://host:8786   on the workers of a Dask cluster

how long it takes, on two processors, about:
  hidden, nuisances and decide 3 h; ideal and friction 1 h; speeds 20 minutes; loaded, tracking,
  sparsity and consistency 5 to 10 minutes; measured 1 to 2 minutes an arm.

what comes out, in the folder:
  cases.jsonl (every case, a line each, as it is done), summary.json (the numbers of the table), and
  the picture, named after the study.

Interrupt it with Ctrl-C; the same command continues where it stopped."""


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("study", metavar="NAME", help=", ".join(STUDIES))
    recordings = "of measured: the folder of the recordings"
    parser.add_argument("recordings", metavar="RECORDINGS", nargs="?", type=Path, help=recordings)
    known = "of measured: a folder of files that say what is known of the arms (docs/studies.md)"
    rows = [
        ("--output", Path, "FOLDER", "default: study_NAME; made if it is missing"),
        ("--known", Path, "FOLDER", f"{known}; default: every known.json below RECORDINGS"),
    ]
    add_rows(parser, rows)
    parser.add_argument(
        "--quick", "--small", action="store_true", help="a small study, to see it work"
    )
    before = [
        ("--seed", int, "", "seed of all random numbers (default: 0)"),
        ("--robots", int, "N", "how many random robots of each kind"),
    ]
    add_rows(parser, before)
    models = "only these, as in vrbfs or motor+fri"
    parser.add_argument("--models", nargs="+", default=[], metavar="MODEL", help=models)
    after = [
        ("--cases --only", str, "PATTERN", "only the cases of this name, with * and ?"),
        ("--list", bool, "", "only name the cases"),
        ("--keep", bool, "", "keep the recordings, and use those that are there"),
        ("--record", bool, "", "only make the recordings, for a later run with --keep"),
    ]
    add_rows(parser, after)
    workers = [
        ("--jobs", int, "N", "processes of one thread (default: the processors)"),
        ("--scheduler", str, "ADDRESS", "address of a Dask cluster that does the work"),
    ]
    add_rows(parser.add_mutually_exclusive_group(), workers)
    parser.set_defaults(seed=0, cases="*")
    add_common(parser, effects=False)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    check_seed(arguments)
    if arguments.json not in (None, "-"):
        check_file(Path(arguments.json), "--json", force=arguments.force)
    kind = study_class(arguments.study)
    from lagrangian_ff.report.style import png
    from lagrangian_ff.studies.run import Folder, record_all
    from lagrangian_ff.studies.run import run as run_study
    from lagrangian_ff.studies.study import Request
    from lagrangian_ff.studies.workers import cluster, processes

    output: Path = arguments.output or Path(f"study_{arguments.study}")
    request = Request(
        seed=arguments.seed,
        quick=arguments.quick,
        only=arguments.cases,
        robots=arguments.robots,
        models=names(arguments.models),
        keep=arguments.keep,
        recordings=arguments.recordings,
        known=arguments.known,
    )
    study = kind(request, output)
    if arguments.list:
        console.say(case.name for case in study.cases())
        return 0
    claim(output / study.name, "--output")
    workers = cluster(arguments.scheduler) if arguments.scheduler else processes(arguments.jobs)
    if arguments.record:
        with progress_bar(f"recording {study.name}") as progress:
            console.say(record_all(study, output, workers, progress))
        return 0
    with progress_bar(f"study {study.name}") as progress:
        lines = run_study(study, output, workers, progress)
    results = study.results(lines)
    numbers = results.record()
    folder = Folder(output, study.name)
    folder.summary.write_text(json.dumps(numbers, indent=1), encoding="utf-8")
    folder.picture.write_bytes(png(results.figure()))
    write_record(arguments.json, numbers)
    console.say(results.table())
    console.say(f"saved: {folder.lines}, {folder.summary}, {folder.picture}")
    return 0
