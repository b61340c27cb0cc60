"""`diagnose`: which physical effect a model lacks."""

from argparse import ArgumentParser, Namespace
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff import report
from lagrangian_ff.cli.common import designed, options
from lagrangian_ff.cli.common.console import Console, progress_bar
from lagrangian_ff.cli.common.outputs import check_outputs, check_sources, whole, write_record
from lagrangian_ff.cli.common.sources import LoadedModel
from lagrangian_ff.cli.text.diagnose import (
    fall_table,
    next_steps,
    say_changed,
    say_checks,
    say_diagnosis,
    say_not_observable,
)
from lagrangian_ff.errors import UserError

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis import Changed, DiagnosisRun, Round
    from lagrangian_ff.diagnosis.preflight import Check
    from lagrangian_ff.identification import Model
    from lagrangian_ff.recording import Motion

    Motions = Sequence[Motion]

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
  lagrangian_ff diagnose model.npz bag --apply --curves --output better.npz
  lagrangian_ff diagnose last_year.npz bag --since
  lagrangian_ff diagnose model.npz bag --effects-file my_effects.py

what comes out:
  faults of the measurement, to be fixed first;
  what changed since the model was identified, where it errs clearly more than it did then;
  the verdict, and for each finding its evidence, size, and error before and after:
      confirmed    helps on motion that was not used to find it
      ambiguous    one of several that look the same on this motion
      suggested    the evidence is strong, the confirmation is not
  what touched the arm for two seconds or less while it was recorded, and when;
  what is left unexplained, named by what it depends on;
  what this motion could not have shown, and the motion to do;
  with --apply a model with everything confirmed, its history included.

With --confirm the motion that was not used is another recording of the same arm, which is better;
without, the last third of SOURCE is held back for it. Nothing less than confirmed is ever added by
itself; lagrangian_ff add adds what you want."""

CHECKED_EACH = ("stamps",)
"""Checks that are shown of each recording even if nothing is serious."""


def add_arguments(parser: ArgumentParser) -> None:
    # Defaults of the search stand in the engine alone.
    options.add_model(parser)
    options.add_sources(parser, "searched together")
    confirm = (
        "other recordings of the same arm, to confirm on (default: the last third of SOURCE is "
        "held back)"
    )
    options.add_list(parser, "--confirm", "SOURCE", confirm, Path)
    steps = (
        "look for at most N effects; with --apply also for at most N rounds of looking and adding "
        "(default: 6)"
    )
    since = (
        "ask what changed since the model was identified, friction, masses or a drive's gain: "
        "SOURCE against the data that the model keeps (without it this is asked only where the "
        "model errs clearly more than on motion left out when it was identified)"
    )
    gear = (
        "the kind of gear of all joints, or JOINT=GEAR; what is usual in it is shown beside the "
        "evidence, and decides nothing: harmonic, cycloidal, planetary, belt, cable, direct"
    )
    expected = (
        "what excite --json wrote of the designed motion that SOURCE is a recording of: findings "
        "stand beside what it promised"
    )
    add = "add what is confirmed, look again until nothing is, and write the model"
    curves = (
        "with --apply: take in as curves, too, what no known effect fits, if unseen motion has it "
        "and the error falls"
    )
    rows = [
        ("--steps", int, "N", steps),
        ("--since", bool, "", since),
        ("--gear", list, "GEAR", gear),
        ("--apply", bool, "", add),
        ("--curves", bool, "", curves),
        ("--output", Path, "NEW.npz", "with --apply: the model file to write"),
        ("--expected", Path, "DESIGN.json", expected),
    ]
    options.add_rows(parser, rows)
    options.add_report(parser)
    options.add_reading(parser)
    options.add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    _check(arguments)
    promised = designed.promised(arguments.expected)
    options.load_own_effects(arguments, console)
    from lagrangian_ff.diagnosis import believed, run_record

    loaded = LoadedModel.of(arguments, console)
    motions = loaded.motions(arguments.sources, console)
    confirm = loaded.motions(arguments.confirm, console)
    if not confirm:
        console.note("no --confirm: the last third of the motion is held back to confirm on")
        console.say()
    changed = _changed(loaded.model, motions, arguments)
    checks = believed(_checks(loaded.model, motions, confirm), changed)
    say_checks(checks, console)
    found = _found(loaded.model, motions, confirm, arguments)
    gears = options.gears(arguments.gear, loaded.model.joints)
    found = replace(found, checks=checks, changed=changed, gears=gears)
    after = next((one.after for one in reversed(found.rounds) if one.after is not None), None)
    if after is not None:
        with whole(arguments.output) as path:
            after.save(path)
    if arguments.report is not None:
        with whole(arguments.report) as path:
            report.diagnose_page(path, found)
    if arguments.json is not None:
        write_record(arguments.json, run_record(found) | designed.outcome_record(promised, found))
    _say(found, arguments, console)
    designed.say_outcomes(promised, found, console)
    return 0


def _checks(model: "Model", motions: "Motions", confirm: "Motions") -> "tuple[Check, ...]":
    """Return what the checks of the measurement find, what is serious first.

    What the motion covers is checked for all that is searched together, faults for each recording.
    """
    from lagrangian_ff.diagnosis.preflight import preflight
    from lagrangian_ff.recording.motion import concatenate

    every = [*motions, *confirm]
    alone = len(motions) == 1
    with progress_bar("checking the measurement") as progress:
        checks = preflight(model, concatenate(motions), confirm)
        checks = [one for one in checks if alone or one.check not in CHECKED_EACH]
        known = {(one.check, one.joint) for one in checks if one.serious}
        for number, motion in enumerate(confirm if alone else every):
            progress(number / len(every), motion.source)
            for one in preflight(model, motion, kind=False):
                new = (one.check, one.joint) not in known
                if (one.serious and new) or one.check in CHECKED_EACH:
                    checks.append(replace(one, source=motion.source))
    return tuple(sorted(checks, key=lambda one: not one.serious))


def _changed(
    model: "Model", motions: "Motions", arguments: Namespace
) -> "tuple[Changed, ...] | None":
    """Return what changed since the identification; None if that is neither asked nor seen."""
    from lagrangian_ff.diagnosis import changed_if_misfit, changed_since
    from lagrangian_ff.diagnosis.search.forward import MOST_STEPS
    from lagrangian_ff.recording.motion import concatenate

    steps = MOST_STEPS if arguments.steps is None else arguments.steps
    ask = changed_since if arguments.since else changed_if_misfit
    with progress_bar("looking for what changed") as progress:
        return ask(model, concatenate(motions), steps, progress)


def _found(
    model: "Model", motions: "Motions", confirm: "Motions", arguments: Namespace
) -> "DiagnosisRun":
    """Return all that the arguments ask for; nothing is written."""
    from lagrangian_ff.diagnosis import DiagnosisRun, compare
    from lagrangian_ff.diagnosis.search.forward import MOST_STEPS
    from lagrangian_ff.diagnosis.where import locate
    from lagrangian_ff.recording.motion import concatenate

    steps = MOST_STEPS if arguments.steps is None else arguments.steps
    where = None
    how = {"apply": arguments.apply, "curves": arguments.curves}
    rounds = tuple(_rounds(model, motions, confirm, steps, **how))
    if arguments.json is not None or arguments.report is not None:
        with progress_bar("looking where it fails") as progress:
            compared = compare(model, concatenate(motions), intervals=True)
            where = locate(model, compared, progress=progress)
    return DiagnosisRun(
        model_file=str(arguments.model),
        sources=tuple(map(str, arguments.sources)),
        confirm=tuple(map(str, arguments.confirm)),
        rounds=rounds,
        where=where,
        output=str(arguments.output) if arguments.apply else "",
    )


def _rounds(
    model: "Model", motions: "Motions", confirm: "Motions", steps: int, *, apply: bool, curves: bool
) -> "Iterator[Round]":
    """Diagnose; with `apply` add what is confirmed and diagnose again until nothing is confirmed.

    Args:
        steps: the most effects a round, and the most rounds.
        curves: whether what is unexplained is added too, as curves.
    """
    from lagrangian_ff import diagnosis as engine

    for number in range(1, steps + 1):
        title = "diagnosing" if number == 1 else f"diagnosing again, round {number}"
        with progress_bar(title) as progress:
            found = engine.diagnose(model, motions, confirm, steps=steps, progress=progress)
        with progress_bar("watching the error fall") as progress:
            found = engine.with_consequences(found, progress)
        if not apply or not (found.confirmed or (curves and found.curves)):
            yield engine.Round(found)
            return
        with progress_bar("adding what is confirmed") as progress:
            model = engine.apply(found, progress, curves=curves)
        yield engine.Round(found, model)


def _say(found: "DiagnosisRun", arguments: Namespace, console: Console) -> None:
    saved = "" if arguments.json in (None, "-") else str(arguments.json)
    for number, one in enumerate(found.rounds, start=1):
        if len(found.rounds) > 1:
            console.say(["", f"round {number}: {one.diagnosis.model.name}"])
        say_diagnosis(one.diagnosis, console, found.changed if number == 1 else None)
        if one.added:
            console.say(["", f"added: {', '.join(one.added)}"])
    if found.usual:
        console.say(["", "what is usual in such gears, which decides nothing"])
        for name, words in found.usual.items():
            console.bullet(f"{name}: {words}")
    if found.changed is not None:
        say_changed(found.changed, found.model_file, console)
    last = found.rounds[-1].diagnosis
    say_not_observable(last.not_observable, last.model.joints, console, found.model_file)
    console.say()
    if found.tried and found.output:
        console.say(f"the fall of the error, rms in N·m, on {found.diagnosis.confirmed_on}")
        console.say(fall_table(found.tried))
        console.say()
    if arguments.report is not None:
        console.say(f"saved: {arguments.report}")
    if found.rounds[0].after is not None:
        console.say([f"saved: {found.output}", "next: how it came to be what it is"])
        console.say(f"  lagrangian_ff history {found.output}")
        return
    if found.output:
        console.say("nothing is confirmed: nothing was added and no model was written")
    console.say(next_steps(found, saved))


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
        both = "--output names the model that --apply writes: give both, or neither"
        missing = "--apply needs --output NEW.npz, the model file to write"
        raise UserError(missing if arguments.apply else both)
    if arguments.curves and not arguments.apply:
        raise UserError("--curves says what --apply adds: give both, or neither")
    reads = [arguments.model, *arguments.sources, *arguments.confirm, arguments.expected]
    check_outputs(arguments, reads, ".npz")
