"""`diagnose`: which physical effect a model lacks."""

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console, progress_bar
from lagrangian_ff.cli.common.diagnosing import Round, checked, diagnosed, falls
from lagrangian_ff.cli.common.outputs import check_outputs, check_sources, whole, write_record
from lagrangian_ff.cli.common.sources import LoadedModel
from lagrangian_ff.cli.text.diagnose import (
    next_steps,
    say_changed,
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
`lagrangian_ff effects` on every joint, compared with what rigid-body dynamics and the effects that
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
    # Defaults of the search stand in the engine alone.
    options.add_model(parser)
    options.add_sources(parser, "searched together")
    options.add_list(
        parser, "--confirm", "SOURCE",
        "other recordings of the same arm, to confirm on (default: the last third of SOURCE is "
        "held back)", Path,
    )  # fmt: skip
    parser.add_argument("--steps", type=int, metavar="N",
        help="look for at most N effects; with --apply also for at most N rounds of looking and "
        "adding (default: 6)")  # fmt: skip
    parser.add_argument("--since", action="store_true",
        help="also ask what changed since the model was identified, friction or masses: SOURCE "
        "against the data that the model keeps")  # fmt: skip
    parser.add_argument("--apply", action="store_true",
        help="add what is confirmed, look again until nothing is, and write the model")  # fmt: skip
    parser.add_argument(
        "--output", type=Path, metavar="NEW.npz", help="with --apply: the model file to write"
    )
    options.add_report(parser)
    options.add_reading(parser)
    options.add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    _check(arguments)
    options.load_own_effects(arguments, console)
    from lagrangian_ff.diagnosis.search.forward import MOST_STEPS

    loaded = LoadedModel.of(arguments, console)
    model, motions = loaded.model, loaded.motions(arguments.sources, console)
    confirm = loaded.motions(arguments.confirm, console)
    if not confirm:
        console.note("no --confirm: the last third of the motion is held back to confirm on")
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
    """Return what differs from the data that the model was identified from."""
    from lagrangian_ff.diagnosis import changed_since
    from lagrangian_ff.recording.motion import concatenate

    with progress_bar("looking for what changed") as progress:
        found = changed_since(model, concatenate(motions), steps, progress)
    return [one.record() for one in found]


def _record(rounds: Sequence[Round], arguments: Namespace) -> dict[str, Any]:
    """Return what was found in the model as it was given, and what adding it led to."""
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
    """Write the JSON and the page, both with where the model fails."""
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
    model = str(arguments.model)
    saved = "" if arguments.json in (None, "-") else str(arguments.json)
    following = next_steps(record, model, record["sources"], record["confirm"], saved)
    for number, one in enumerate(rounds, start=1):
        if len(rounds) > 1:
            console.say(["", f"round {number}: {one.diagnosis.model.name}"])
        say_diagnosis(one.record, console)
        if one.added:
            console.say(["", f"added: {', '.join(one.added)}"])
    if arguments.since:
        say_changed(record["changed"], model, console)
    say_not_observable(rounds[-1].record, model, console)
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
        console.say([f"saved: {arguments.output}", "next: how it came to be what it is"])
        console.say(f"  lagrangian_ff history {arguments.output}")


def _check(arguments: Namespace) -> None:
    check_sources([*arguments.sources, *arguments.confirm])
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
    reads = [arguments.model, *arguments.sources, *arguments.confirm]
    check_outputs(arguments, reads, ".npz")
