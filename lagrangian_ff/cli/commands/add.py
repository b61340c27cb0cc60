"""`add`: a model with one more effect, refitted from the data that it keeps."""

from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangian_ff.cli.common.because import Because, found_in
from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.options import add_force, add_json, names
from lagrangian_ff.cli.common.outputs import check_file, whole, write_record
from lagrangian_ff.cli.common.own_effects import add_effects_file, effect_named, load_own_effects
from lagrangian_ff.cli.common.progress import progress_bar
from lagrangian_ff.cli.text.effects import equations, parameter_table
from lagrangian_ff.cli.text.history import before_after_table
from lagrangian_ff.cli.text.layout import number
from lagrangian_ff.errors import UserError

if TYPE_CHECKING:
    from lagrangian_ff.effects import Effect
    from lagrangian_ff.identification import Model

NAME = "add"
SUMMARY = "add a physical effect to a model, refit it, and see the error fall"
USAGE = "MODEL EFFECT --joint J [--joint K ...] [options]"
DESCRIPTION = """\
Adds an effect to one joint of a model, or to several, refits the model from the data that it
keeps, and writes it to a new file. No recording is needed. What the effect is not linear in, its
shape, is searched unless it is given."""
EPILOG = """\
examples:
  lagrangian_ff add model.npz stribeck --joint joint_2
  lagrangian_ff add model.npz ripple --joint joint_2 --shape order=18 --output better.npz
  lagrangian_ff add model.npz ripple --joint joint_2 --because missing.json

what comes out:
  the error of each joint before and after, on the data that the model holds out (or on blocks
  left out in turn, where it learned from everything);
  the parameters of the effect with 90 % intervals;
  MODEL+EFFECT@JOINT.npz, or the name given with --output.

What the model has already, by this name or as the same torque under another, is refused."""


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("model", type=Path, metavar="MODEL", help="a model file of identify")
    parser.add_argument(
        "effect", metavar="EFFECT", help="its name; lagrangian_ff effects lists them"
    )
    parser.add_argument(
        "--joint",
        action="append",
        default=[],
        metavar="JOINT",
        help="the joint it acts on; may be given several times",
    )
    parser.add_argument(
        "--shape",
        nargs="+",
        action="extend",
        default=[],
        metavar="NAME=VALUE",
        help="what the effect is not linear in; what is not given is searched",
    )
    parser.add_argument(
        "--because",
        type=Path,
        metavar="DIAGNOSIS.json",
        help="what diagnose --json wrote: the history tells its evidence, and its shape is used",
    )
    parser.add_argument(
        "--output",
        type=Path,
        metavar="NEW.npz",
        help="the model file to write (default: MODEL+EFFECT@JOINT.npz beside MODEL)",
    )
    add_effects_file(parser)
    add_json(parser)
    add_force(parser)


def run(arguments: Namespace) -> int:
    """See `Command`."""
    console = Console(arguments.json)
    joints = tuple(dict.fromkeys(names(arguments.joint)))
    if not joints:
        raise UserError("add needs a joint to act on: --joint JOINT")
    output = arguments.output or _usual_output(arguments.model, arguments.effect, joints)
    _check_outputs(arguments, output)
    load_own_effects(arguments, console)
    from lagrangian_ff.diagnosis import add
    from lagrangian_ff.identification import Model

    model = before = Model.load(arguments.model)
    effect = effect_named(arguments.effect)
    shape = _shape(effect, arguments.shape, model.joints)
    reasons = [_because(arguments.because, effect.name, joint) for joint in joints]
    for joint, because in zip(joints, reasons, strict=True):
        with progress_bar(f"adding {effect.name} on {joint}") as progress:
            model = add(model, effect.name, joint, shape or because.shape, because.why, progress)
    with whole(output) as path:
        model.save(path)
    record = _record(before, model, effect.name, joints, arguments.model, output)
    write_record(arguments.json, record)
    _say(record, effect.caution, console)
    return 0


def _because(diagnosis: Path | None, effect: str, joint: str) -> Because:
    if diagnosis is None:
        return Because({"why": "added by hand"}, {})
    return found_in(diagnosis, effect, joint)


def _usual_output(model: Path, effect: str, joints: Sequence[str]) -> Path:
    """Named as models are; a joint's name may hold what a file's may not."""
    added = "".join(f"+{effect}@{joint}" for joint in joints).replace("/", "_")
    return model.with_name(f"{model.stem}{added}.npz")


def _check_outputs(arguments: Namespace, output: Path) -> None:
    if not arguments.model.exists():
        raise UserError(f"{arguments.model}: no such file")
    keep = [path for path in (arguments.model, arguments.because) if path is not None]
    check_file(output, "--output", force=arguments.force, suffix=".npz", keep=keep)
    if arguments.json not in (None, "-"):
        keep.append(output)
        check_file(Path(arguments.json), "--json", force=arguments.force, keep=keep)


def _shape(
    effect: "Effect", given: Sequence[str], joints: Sequence[str]
) -> Mapping[str, float] | None:
    """The shape from name=value; a joint's name stands for its number.

    Raises:
        UserError: it is not the shape of this effect.
    """
    if not given:
        return None
    known = [shape.name for shape in effect.shapes]
    wanted = ", ".join(known) if known else "none: its torque is linear in all its numbers"
    values: dict[str, float] = {}
    for part in names(given):
        name, sign, text = part.partition("=")
        if not sign or name not in known:
            raise UserError(
                f"--shape {part}: expected name=value; {effect.name} has the shapes {wanted}"
            )
        try:
            values[name] = float(joints.index(text)) if text in joints else float(text)
        except ValueError:
            raise UserError(f"--shape {part}: '{text}' is no number") from None
        shape = effect.shapes[known.index(name)]
        value = values[name]
        if not shape.low <= value <= shape.high or (shape.whole and not value.is_integer()):
            raise UserError(
                f"--shape {part}: expected {'a whole ' if shape.whole else ''}{shape.name} between "
                f"{number(shape.low)} and {number(shape.high)} {shape.unit} ({shape.meaning})"
            )
    return values


def _record(
    before: "Model",
    after: "Model",
    effect: str,
    joints: Sequence[str],
    model: Path,
    output: Path,
) -> dict[str, Any]:
    old, new = before.record, after.record
    errors = [one["joints"] for one in (old, new)]
    assert all(isinstance(one, Mapping) for one in errors)
    effects = new["effects"]
    assert isinstance(effects, Sequence)
    return {
        "model": str(model),
        "output": str(output),
        "model_name": after.name,
        "effect": effect,
        "joint_names": list(joints),
        "error_before": old["rmse"],
        "error_after": new["rmse"],
        "joints": {
            name: {"before": errors[0][name]["rmse"], "after": errors[1][name]["rmse"]}  # type: ignore[index]
            for name in after.joints
        },
        "judged_on": new["judged_on"],
        "effects": [one for one in effects if one["effect"] == effect and one["joint"] in joints],
    }


def _say(record: Mapping[str, Any], caution: str, console: Console) -> None:
    console.say(f"{record['model_name']}, judged on {record['judged_on']}")
    console.say(before_after_table(record["joints"]))
    console.say(["", "what was added, torque in N·m with qd in rad/s"])
    console.say(equations(record["effects"]))
    console.say(["", "its parameters with 90 % intervals"])
    console.say(parameter_table(record["effects"]))
    console.say()
    if caution:
        console.note(f"{record['effect']}: {caution}", "")
    worst = [joint for joint in record["joint_names"]
             if record["joints"][joint]["after"] >= record["joints"][joint]["before"]]  # fmt: skip
    if worst:
        console.note(
            f"the error on {', '.join(worst)} did not fall: on this data the effect is not missed",
            "",
        )
    console.say(
        [
            f"error of all joints: {number(record['error_before'])} -> "
            f"{number(record['error_after'])} N·m",
            f"saved: {record['output']}",
            "next:",
            f"  lagrangian_ff history {record['output']}",
        ]
    )
