"""`propose`: formulas for a torque that no known effect explains."""

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console, progress_bar, table
from lagrangian_ff.cli.common.outputs import check_outputs, check_sources, whole, write_record
from lagrangian_ff.cli.common.sources import LoadedModel
from lagrangian_ff.cli.text.diagnose import fitted_effect
from lagrangian_ff.cli.text.effects import equations, parameter_table
from lagrangian_ff.errors import UserError
from lagrangian_ff.numbers import chance, number
from lagrangian_ff.record_json import to_json

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis.proposing import Proposals

NAME = "propose"
SUMMARY = "propose formulas for a torque that no known effect explains"
USAGE = "MODEL SOURCE [SOURCE ...] [--joint J] [--confirm SOURCE ...] [options]"
DESCRIPTION = """\
Searches a grammar of physical forms for what a model lacks on a joint, or for the curve that it has
there: dry and viscous friction and friction in proportion to the load, times functions of position,
velocity, acceleration, load, the time since a reversal, and the other joints' positions. Each
formula is judged as an effect of the catalogue is: the whole grammar is paid for in what chance may
give, look-alikes are rivals, and frozen it must explain motion that was not used to find it."""
EPILOG = """\
examples:
  lagrangian_ff propose model.npz bag --joint joint_3 --confirm other_bag --output mine.json
  lagrangian_ff propose model.npz bag --joint joint_3 --over position --confirm other_bag
  lagrangian_ff add model.npz formula_friction_bump_position --joint joint_3 \\
      --effects-file mine.json

what comes out:
  three formulas, the best first, each with its verdict, log evidence, the error before and after
  on motion not used to find it, its parameters with 90 % intervals, and what it might be;
  with --output a file of these formulas for --effects-file.

A formula says how a torque looks, not what causes it. Without --joint it is the joint with a curve,
or that on which most is missing."""


def add_arguments(parser: ArgumentParser) -> None:
    options.add_model(parser)
    options.add_sources(parser, "searched together")
    confirm = (
        "other recordings of the same arm, to confirm on (default: the last third of SOURCE is "
        "held back)"
    )
    options.add_list(parser, "--confirm", "SOURCE", confirm, Path)
    over = (
        "what the formulas may be of: position, velocity, acceleration, load, reversal; of another "
        "joint as in position@joint_2 (default: all)"
    )
    options.add_rows(parser, [
        ("--joint", str, "JOINT", "the joint it is on"),
        ("--over", list, "COORDINATE", over),
        ("--output", Path, "MINE.json", "write the formulas, for --effects-file"),
    ])  # fmt: skip
    options.add_reading(parser)
    options.add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    check_sources([*arguments.sources, *arguments.confirm])
    same = {path.resolve() for path in arguments.sources}
    if any(source.resolve() in same for source in arguments.confirm):
        raise UserError("--confirm: confirm on a recording that the search does not see")
    reads = [arguments.model, *arguments.sources, *arguments.confirm]
    check_outputs(arguments, reads, ".json")
    options.load_own_effects(arguments, console)
    from lagrangian_ff.diagnosis.proposing import proposals_record, propose

    loaded = LoadedModel.of(arguments, console)
    motions = loaded.motions(arguments.sources, console)
    confirm = loaded.motions(arguments.confirm, console)
    over = options.names(arguments.over)
    with progress_bar("proposing formulas") as progress:
        found = propose(loaded.model, motions, confirm, arguments.joint, over, progress)
    if arguments.output is not None:
        with whole(arguments.output) as path:
            path.write_text(to_json(found.record()), encoding="utf-8")
    if arguments.json is not None:
        write_record(arguments.json, proposals_record(found))
    _say(found, arguments, loaded.model.joints, console)
    return 0


def _say(found: "Proposals", arguments: Namespace, joints: Sequence[str], console: Console) -> None:
    console.say(
        ["", f"{found.joint}: {found.tried} formulas and curves competed; of so many, chance gives "
         f"the best {number(found.threshold)} nats once in twenty times"]
    )  # fmt: skip
    header = ["", "formula", "verdict", "gain", "p", "error before [N·m]", "after"]
    rows = [
        [
            str(rank),
            one.name,
            one.finding.verdict.value,
            number(one.finding.log_bayes_factor),
            chance(one.finding.p_value),
            *map(number, one.finding.errors),
        ]
        for rank, one in enumerate(found.proposals, start=1)
    ]
    console.say(table(header, rows))
    with_curve = (
        "" if found.curve_error is None else f"; with the curve {number(found.curve_error)}"
    )
    console.paragraph(
        f"error: rms of {found.joint} on {found.confirmed_on}{with_curve}. The best curve gains "
        f"{number(found.curve)} nats",
        "  ",
    )
    for rank, one in enumerate(found.proposals, start=1):
        console.say(["", f"{rank}. {one.name}"])
        console.paragraph(one.words, "   ")
        fitted = fitted_effect(one.finding, joints)
        console.say([f"  {found.joint}  τ = {one.formula}", *equations([fitted])])
        if one.finding.doubt is not None:
            console.paragraph(f"no more than suggested: {one.finding.doubt.words}", "   ")
        if one.finding.rivals:
            console.paragraph(f"as good on this motion: {', '.join(one.finding.rivals)}", "   ")
        console.say(parameter_table([fitted]))
    console.say()
    if arguments.output is None:
        console.say("next: --output MINE.json keeps these formulas for --effects-file")
        return
    console.say([f"saved: {arguments.output}", "next:"])
    if found.proposals:
        console.say(
            f"  lagrangian_ff add {arguments.model} {found.proposals[0].name} --joint "
            f"{found.joint} --effects-file {arguments.output}"
        )
