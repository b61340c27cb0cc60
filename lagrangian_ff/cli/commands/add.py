"""`add`: a model with one more effect, refitted from the data that it keeps."""

import json
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console, progress_bar
from lagrangian_ff.cli.common.outputs import check_outputs, whole, write_record
from lagrangian_ff.cli.text.effects import say_equations
from lagrangian_ff.cli.text.history import before_after_table
from lagrangian_ff.errors import UserError
from lagrangian_ff.numbers import number
from lagrangian_ff.record_json import why_of

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

NEEDED = {"effect", "joints", "shape", "why", "verdict", "evidence_gain", "p_value"}
"""Fields that are read of a finding."""


@dataclass(frozen=True)
class Because:
    """The reason for which an effect is added to a joint.

    Attributes:
        why: for the model's history.
        shape: the numbers that the effect is not linear in, as the diagnosis found them.
    """

    why: Mapping[str, object]
    shape: Mapping[str, float]


def add_arguments(parser: ArgumentParser) -> None:
    options.add_model(parser)
    parser.add_argument(
        "effect", metavar="EFFECT", help="its name; lagrangian_ff effects lists them"
    )
    parser.add_argument("--joint", action="append", default=[], metavar="JOINT",
        help="the joint it acts on; may be given several times")  # fmt: skip
    options.add_list(
        parser, "--shape", "NAME=VALUE",
        "what the effect is not linear in; what is not given is searched",
    )  # fmt: skip
    parser.add_argument("--because", type=Path, metavar="DIAGNOSIS.json",
        help="what diagnose --json wrote: the history holds its evidence, and its shape is used",
    )  # fmt: skip
    parser.add_argument("--output", type=Path, metavar="NEW.npz",
        help="the model file to write (default: MODEL+EFFECT@JOINT.npz beside MODEL)")  # fmt: skip
    options.add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    joints = tuple(dict.fromkeys(options.names(arguments.joint)))
    if not joints:
        raise UserError("add needs a joint to act on: --joint JOINT")
    if arguments.output is None:
        arguments.output = _usual_output(arguments.model, arguments.effect, joints)
    if not arguments.model.exists():
        raise UserError(f"{arguments.model}: no such file")
    check_outputs(arguments, [arguments.model, arguments.because], ".npz")
    options.load_own_effects(arguments, console)
    from lagrangian_ff.diagnosis import add
    from lagrangian_ff.identification import Model

    model = before = Model.load(arguments.model)
    effect = options.effect_named(arguments.effect)
    shape = _shape(effect, arguments.shape, model.joints)
    reasons = [_because(arguments.because, effect.name, joint) for joint in joints]
    for joint, because in zip(joints, reasons, strict=True):
        with progress_bar(f"adding {effect.name} on {joint}") as progress:
            model = add(model, effect.name, joint, shape or because.shape, because.why, progress)
    with whole(arguments.output) as path:
        model.save(path)
    record = _record(before, model, effect.name, joints, arguments)
    write_record(arguments.json, record)
    _say(record, effect.caution, console)
    return 0


def _because(diagnosis: Path | None, effect: str, joint: str) -> Because:
    """Return why an effect is added to a joint: the finding of a diagnosis, if one is given.

    Raises:
        UserError: there is no such file, it is no diagnosis, or it found no such effect to add.
    """
    if diagnosis is None:
        return Because({"why": "added by hand"}, {})
    findings = _findings(diagnosis)
    for one in findings:
        if one["effect"] == effect and joint in one["joints"] and one["why"]:
            return Because(why_of(one), one["shape"])
    others = [f"{one['effect']} on {one['joints'][0]}" for one in findings if one["why"]]
    raise UserError(
        f"--because {diagnosis}: it does not find {effect} on {joint}; it finds "
        f"{', '.join(others) or 'nothing to add'}"
    )


def _findings(path: Path) -> list[dict[str, Any]]:
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UserError(f"--because {path}: {error.strerror or error}") from None
    except ValueError:
        record = None
    findings = record.get("findings") if isinstance(record, dict) else None
    if not isinstance(findings, list) or not all(
        isinstance(one, dict) and one.keys() >= NEEDED for one in findings
    ):
        raise UserError(
            f"--because {path}: expected the file that lagrangian_ff diagnose --json writes"
        )
    return findings


def _usual_output(model: Path, effect: str, joints: Sequence[str]) -> Path:
    """Return MODEL+EFFECT@JOINT.npz; a joint's name may hold what a file's may not."""
    added = "".join(f"+{effect}@{joint}" for joint in joints).replace("/", "_")
    return model.with_name(f"{model.stem}{added}.npz")


def _shape(
    effect: "Effect", given: Sequence[str], joints: Sequence[str]
) -> Mapping[str, float] | None:
    """Return the shape from name=value; a joint's name stands for its number.

    Raises:
        UserError: it is not the shape of this effect.
    """
    if not given:
        return None
    known = [shape.name for shape in effect.shapes]
    wanted = ", ".join(known) if known else "none: its torque is linear in all its numbers"
    values: dict[str, float] = {}
    for part in options.names(given):
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
    before: "Model", after: "Model", effect: str, joints: Sequence[str], arguments: Namespace
) -> dict[str, Any]:
    old: Mapping[str, Any] = before.record
    new: Mapping[str, Any] = after.record
    return {
        "model": str(arguments.model), "output": str(arguments.output), "model_name": after.name,
        "effect": effect, "joint_names": list(joints), "error_before": old["rmse"],
        "error_after": new["rmse"],
        "joints": {
            name: {"before": old["joints"][name]["rmse"], "after": new["joints"][name]["rmse"]}
            for name in after.joints
        },
        "judged_on": new["judged_on"],
        "effects": [
            one for one in new["effects"] if one["effect"] == effect and one["joint"] in joints
        ],
    }  # fmt: skip


def _say(record: Mapping[str, Any], caution: str, console: Console) -> None:
    console.say(f"{record['model_name']}, judged on {record['judged_on']}")
    console.say(before_after_table(record["joints"]))
    say_equations("what was added, torque", record["effects"], console)
    console.say()
    if caution:
        console.note(f"{record['effect']}: {caution}")
    worst = [joint for joint in record["joint_names"]
             if record["joints"][joint]["after"] >= record["joints"][joint]["before"]]  # fmt: skip
    if worst:
        console.note(
            f"the error on {', '.join(worst)} did not fall: on this data the effect is not missed"
        )
    before, after = number(record["error_before"]), number(record["error_after"])
    console.say(f"error of all joints: {before} -> {after} N·m")
    console.say([f"saved: {record['output']}", "next:"])
    console.say(f"  lagrangian_ff history {record['output']}")
