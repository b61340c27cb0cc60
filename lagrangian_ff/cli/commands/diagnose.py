"""`diagnose`: which physical effect a model lacks."""

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.held import Held
from lagrangian_ff.cli.common.measurement import checked
from lagrangian_ff.cli.common.options import (
    SOURCE_HELP,
    add_conditioning,
    add_force,
    add_json,
    add_topic,
)
from lagrangian_ff.cli.common.outputs import check_file, whole, write_record
from lagrangian_ff.cli.common.own_effects import add_effects_file, load_own_effects
from lagrangian_ff.cli.common.progress import progress_bar
from lagrangian_ff.cli.common.rounds import Round, diagnosed, falls
from lagrangian_ff.cli.text.changed import say_changed
from lagrangian_ff.cli.text.diagnose import (
    next_steps,
    say_checks,
    say_diagnosis,
    say_not_observable,
)
from lagrangian_ff.cli.text.history import fall_table
from lagrangian_ff.errors import UserError

if TYPE_CHECKING:
    from lagrangian_ff.identification import Model
    from lagrangian_ff.recording import Motion

NAME = "diagnose"
SUMMARY = "find out which physical effect a model lacks, with the evidence for it"
USAGE = "MODEL SOURCE [SOURCE ...] [--confirm SOURCE ...] [options]"
DESCRIPTION = """\
Looks for the physical effects that a model lacks, one after the other: every effect of
`lagrangian_ff effects` on every joint, held against what rigid-body dynamics and the effects that
the model has leave of the measured torque. What stands out against chance is tried, with frozen
coefficients, on motion that was not used to find it. Where nothing known fits, it says so."""
EPILOG = """\
examples:
  lagrangian_ff diagnose model.npz bag --confirm other_bag
  lagrangian_ff diagnose model.npz bag --report missing.html --json missing.json
  lagrangian_ff diagnose model.npz bag --apply --output better.npz
  lagrangian_ff diagnose last_year.npz bag --since
  lagrangian_ff diagnose model.npz bag --effects-file my_effects.py

what comes out:
  faults of the measurement, to be fixed first;
  the verdict, and for each finding its evidence, size, and error before and after:
      confirmed    helps on motion that was not used to find it
      ambiguous    one of several that look the same on this motion
      suggested    the evidence is strong, the confirmation is not
  what is left unexplained, named by what it depends on;
  what this motion could not have shown, and the motion to do;
  with --apply a model with everything confirmed, its history included.

With --confirm the motion that was not used is another recording of the same arm, which is better;
without, the last third of SOURCE is held back for it. Nothing less than confirmed is ever added by
itself; lagrangian_ff add adds what you want."""


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`. Defaults of the search stand in the engine alone."""
    parser.add_argument("model", type=Path, metavar="MODEL", help="a model file of identify")
    parser.add_argument(
        "sources",
        type=Path,
        nargs="+",
        metavar="SOURCE",
        help=f"{SOURCE_HELP}; several are searched together",
    )
    parser.add_argument(
        "--confirm",
        type=Path,
        nargs="+",
        action="extend",
        default=[],
        metavar="SOURCE",
        help="other recordings of the same arm, to confirm on (default: the last third of SOURCE "
        "is held back)",
    )
    parser.add_argument(
        "--steps",
        type=int,
        metavar="N",
        help="look for at most so many effects; with --apply also at most so many rounds of "
        "looking and adding (default: 6)",
    )
    parser.add_argument(
        "--since",
        action="store_true",
        help="ask too what changed since the model was identified, friction or masses: SOURCE "
        "against the data that the model keeps",
    )
    parser.add_argument(
        "--apply",
        action="store_true",
        help="add what is confirmed, look again until nothing is, and write the model",
    )
    parser.add_argument(
        "--output", type=Path, metavar="NEW.npz", help="with --apply: the model file to write"
    )
    parser.add_argument(
        "--report", type=Path, metavar="FILE.html", help="write a page with interactive figures"
    )
    add_topic(parser)
    add_conditioning(parser)
    add_effects_file(parser)
    add_json(parser)
    add_force(parser)


def run(arguments: Namespace) -> int:
    """See `Command`."""
    console = Console(arguments.json)
    _check(arguments)
    load_own_effects(arguments, console)
    from lagrangian_ff.diagnosis.search.forward import MOST_STEPS

    held = Held.of(arguments, console)
    model, motions = held.model, held.motions(arguments.sources, console)
    confirm = held.motions(arguments.confirm, console)
    if not confirm:
        console.note("no --confirm: the last third of the motion is held back to confirm on", "")
        console.say()
    checks = checked(model, motions, confirm)
    say_checks(checks, console)
    steps = MOST_STEPS if arguments.steps is None else arguments.steps
    changed = _changed(model, motions, steps) if arguments.since else None
    rounds = diagnosed(model, motions, confirm, steps, apply=arguments.apply)
    record = {**_record(rounds, arguments), "preflight": checks}
    if changed is not None:
        record["changed"] = changed
    after = next((one.after for one in reversed(rounds) if one.after is not None), None)
    if after is not None:
        with whole(arguments.output) as path:
            after.save(path)
    if arguments.json is not None or arguments.report is not None:
        _write(record, model, motions, arguments)
    _say(rounds, record, arguments, console)
    return 0


def _changed(model: "Model", motions: "Sequence[Motion]", steps: int) -> list[dict[str, Any]]:
    """What differs from the data that the model was identified from."""
    from lagrangian_ff.diagnosis import changed_since
    from lagrangian_ff.recording.motion import concatenate

    with progress_bar("asking what changed") as progress:
        return [one.record() for one in changed_since(model, concatenate(motions),
                                                      steps, progress)]  # fmt: skip


def _record(rounds: Sequence[Round], arguments: Namespace) -> dict[str, Any]:
    """What was found in the model as it was given, and what adding it led to."""
    first = rounds[0].record
    record = {
        **first,
        "model": str(arguments.model),
        "model_name": first["model"],
        "sources": [str(source) for source in arguments.sources],
        "confirm": [str(source) for source in arguments.confirm],
    }
    if arguments.apply:
        record["steps"] = falls(rounds)
        record["applied"] = {
            "output": str(arguments.output) if rounds[0].after is not None else None,
            "added": [name for one in rounds for name in one.added],
            "rounds": [{"verdict": one.record["verdict"], "added": one.added} for one in rounds],
        }
    return record


def _write(
    record: dict[str, Any], model: "Model", motions: "Sequence[Motion]", arguments: Namespace
) -> None:
    """The JSON and the page; both with where the model fails."""
    from lagrangian_ff.diagnosis import compare
    from lagrangian_ff.diagnosis.where import locate
    from lagrangian_ff.recording.motion import concatenate

    with progress_bar("looking where it fails") as progress:
        compared = compare(model, concatenate(motions), intervals=True)
        where = locate(model, compared, progress=progress)
    if arguments.report is not None:
        from lagrangian_ff.report import diagnose_page

        with whole(arguments.report) as path:
            diagnose_page(path, {**record, "compare": where.record(series=True)})
    write_record(arguments.json, {**record, "compare": where.record()})


def _say(
    rounds: Sequence[Round], record: dict[str, Any], arguments: Namespace, console: Console
) -> None:
    saved = "" if arguments.json in (None, "-") else str(arguments.json)
    following = next_steps(
        record, str(arguments.model), record["sources"], record["confirm"], saved
    )
    for number, one in enumerate(rounds, start=1):
        if len(rounds) > 1:
            console.say(["", f"round {number}: {one.before.name}"])
        say_diagnosis(one.record, console)
        if one.added:
            console.say(["", f"added: {', '.join(one.added)}"])
    if arguments.since:
        say_changed(record["changed"], str(arguments.model), console)
    say_not_observable(rounds[-1].record, str(arguments.model), console)
    console.say()
    if record["steps"] and arguments.apply:
        console.say(f"the fall of the error, rms in N·m, on {record['confirmed_on']}")
        console.say(fall_table(record["steps"]))
        console.say()
    if arguments.report is not None:
        console.say(f"saved: {arguments.report}")
    if not arguments.apply:
        console.say(following)
    elif rounds[0].after is None:
        console.say("nothing is confirmed: nothing was added and no model was written")
        console.say(following)
    else:
        console.say(
            [
                f"saved: {arguments.output}",
                "next: how it came to be what it is",
                f"  lagrangian_ff history {arguments.output}",
            ]
        )


def _check(arguments: Namespace) -> None:
    for source in [*arguments.sources, *arguments.confirm]:
        if not source.exists():
            raise UserError(f"{source}: no such file or directory")
    same = {path.resolve() for path in arguments.sources}
    for source in arguments.confirm:
        if source.resolve() in same:
            raise UserError(
                f"--confirm {source}: is searched too; confirm on a recording that the search "
                "does not see, or leave --confirm out to hold the last third back"
            )
    if arguments.steps is not None and arguments.steps < 1:
        raise UserError(f"--steps {arguments.steps}: expected a whole number from 1 up")
    if arguments.apply != (arguments.output is not None):
        raise UserError(
            "--apply needs --output NEW.npz, the model file to write" if arguments.apply
            else "--output names the model that --apply writes: give both, or neither"
        )  # fmt: skip
    keep = [arguments.model, *arguments.sources, *arguments.confirm]
    for option, path, suffix in (
        ("--output", arguments.output, ".npz"),
        ("--report", arguments.report, ".html"),
        ("--json", None if arguments.json in (None, "-") else Path(arguments.json), ""),
    ):
        if path is not None:
            check_file(path, option, force=arguments.force, suffix=suffix, keep=keep)
            keep.append(path)
