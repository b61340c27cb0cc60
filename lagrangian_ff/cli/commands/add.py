"""`add`: a model with one more effect, refitted from the data that it keeps."""

from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff import budget
from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console, progress_bar
from lagrangian_ff.cli.common.outputs import check_outputs, whole, write_record
from lagrangian_ff.cli.text.effects import say_equations
from lagrangian_ff.cli.text.history import before_after_table
from lagrangian_ff.errors import UserError
from lagrangian_ff.numbers import number
from lagrangian_ff.record_json import by_name

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis.record import SavedFinding
    from lagrangian_ff.effects import Effect
    from lagrangian_ff.identification import Model
    from lagrangian_ff.identification.history import Step
    from lagrangian_ff.identification.records import FittedEffect

FORM = ("over", "friction", "odd", "monotone")
"""Options that say what a curve is like."""
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
  lagrangian_ff add model.npz curve --joint joint_3 --over velocity --odd
  lagrangian_ff add model.npz curve --joint joint_3 --over position position@joint_4 --friction

a curve is for what diagnose calls unexplained: splines over one or two of position, velocity,
acceleration, load and reversal (the time since the joint turned round), of the joint itself or of
another one. The evidence chooses how smooth it is. Outside what the model has seen it is zero.

what comes out:
  the error of each joint before and after, on the data that the model holds out (or on blocks
  left out in turn, where it learned from everything);
  the parameters of the effect with 90 % intervals;
  MODEL+EFFECT@JOINT.npz, or the name given with --output.

What the model has already, by this name or as the same torque under another, is refused."""


def add_arguments(parser: ArgumentParser) -> None:
    options.add_model(parser)
    effect, joint = (
        ("effect", str, "EFFECT", "its name; lagrangian_ff effects lists them; or curve"),
        ("--joint", str, "JOINT", "the joint it acts on; may be given several times"),
    )
    options.add_rows(parser, [effect])
    options.add_rows(parser, [joint], action="append", default=[])
    options.add_rows(parser, (
        ("--shape", list, "NAME=VALUE",
         "what the effect is not linear in; what is not given is searched"),
        ("--because", Path, "DIAGNOSIS.json",
         "what diagnose --json wrote: the history holds its evidence, and its shape is used"),
        ("--output", Path, "NEW.npz",
         "the model file to write (default: MODEL+EFFECT@JOINT.npz beside MODEL)"),
    ))  # fmt: skip
    options.add_rows(parser.add_argument_group("a curve"), (
        ("--over", list, "COORDINATE",
         "what it is over: one or two of position, velocity, acceleration, load, reversal; of "
         "another joint as in position@joint_2"),
        ("--friction", bool, "", "it changes sign with the direction of motion"),
        ("--odd", bool, "", "f(-x) = -f(x), in the first coordinate"),
        ("--monotone", bool, "", "it only rises, or only falls"),
    ))  # fmt: skip
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
    from lagrangian_ff.identification.history import Step

    model = before = Model.load(arguments.model)
    effect = _effect(arguments, model.joints)
    form = {name: getattr(arguments, name) for name in FORM}
    shape = _shape(effect, arguments.shape, model.joints)
    why: dict[str, Mapping[str, object]] = {joint: {"why": "added by hand"} for joint in joints}
    shapes = dict.fromkeys(joints, shape)
    if arguments.because is not None:
        for joint in joints:
            finding = _because(arguments.because, effect.name, joint)
            why[joint], shapes[joint] = finding.history, shape or finding.shape
    for joint in joints:
        with progress_bar(f"adding {effect.name} on {joint}") as progress:
            name, given = arguments.effect, shapes[joint]
            model = add(model, name, joint, given, why[joint], progress, **form)
    with whole(arguments.output) as path:
        model.save(path)
    step = Step.between(effect.name, before.identified, model.identified)
    there = [one for one in model.identified.effects if one.effect == effect.name]
    added = [one for one in there if one.joint in joints]
    record = {
        "model": str(arguments.model),
        "output": str(arguments.output),
        "model_name": model.name,
        "effect": effect.name,
        "joint_names": list(joints),
        "error_before": step.error_before,
        "error_after": step.error_after,
        "joints": {joint: by_name(error) for joint, error in step.joints.items()},
        "judged_on": step.judged_on,
        "effects": [by_name(one) for one in added],
        "curves": _curves(model, effect.name, joints),
    }
    write_record(arguments.json, record)
    _say(model, effect, step, added, console)
    saved = arguments.output
    console.say([f"saved: {saved}", "next:", f"  lagrangian_ff history {saved}"])
    return 0


def _effect(arguments: Namespace, joints: Sequence[str]) -> "Effect":
    """Return the effect that is named, or the curve that is described.

    Raises:
        UserError: there is no such effect, or no such curve.
    """
    from lagrangian_ff.effects import Over, curve_over
    from lagrangian_ff.effects.curve import NAME as CURVE

    if arguments.effect != CURVE:
        return options.effect_named(arguments.effect)
    if not arguments.over:
        raise UserError("a curve needs one or two coordinates: --over velocity, for example")
    if arguments.shape:
        raise UserError(f"--shape {arguments.shape[0]}: a curve has none; its form is found")
    over = [Over.of(text, joints) for text in options.names(arguments.over)]
    form = {name: getattr(arguments, name) for name in FORM if name != "over"}
    return curve_over(over, **form)


def _curves(model: "Model", name: str, joints: Sequence[str]) -> list[dict[str, object]]:
    """Return the torque of curves over their coordinates, as JSON holds it."""
    from lagrangian_ff.effects import Curve

    found = []
    for term, place in model.basis.slices():
        curve, joint = term.effect, model.joints[term.joint]
        if isinstance(curve, Curve) and curve.name == name and joint in joints:
            at, torque = curve.table(model.coefficients[place])
            over = [
                {"coordinate": one.text(), "unit": one.unit, "at": values.tolist()}
                for one, values in zip(curve.over, at, strict=True)
            ]
            friction = curve.friction
            found.append(
                {"joint": joint, "over": over, "friction": friction, "torque": torque.tolist()}
            )
    return found


def _because(file: Path, effect: str, joint: str) -> "SavedFinding":
    """Return the finding of a diagnosis for which an effect is added to a joint.

    Raises:
        UserError: there is no such file, it is no diagnosis, or it found no such effect to add.
    """
    from lagrangian_ff.diagnosis.record import saved_findings

    try:
        text = budget.text_of(file, UserError)
        findings = [one for one in saved_findings(text) if not one.once]
    except OSError as error:
        raise UserError(f"--because {file}: {error.strerror or error}") from None
    except (ValueError, RecursionError):
        raise UserError(
            f"--because {file}: expected the file that lagrangian_ff diagnose --json writes"
        ) from None
    for one in findings:
        if one.effect == effect and joint in one.joints:
            return one
    others = ", ".join(f"{one.effect} on {one.joints[0]}" for one in findings)
    raise UserError(
        f"--because {file}: it does not find {effect} on {joint}; it finds "
        f"{others or 'nothing to add'}"
    )


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


def _say(
    model: "Model",
    effect: "Effect",
    step: "Step",
    added: "Sequence[FittedEffect]",
    console: Console,
) -> None:
    from lagrangian_ff.effects import Curve

    of = {(one.effect, one.joint) for one in added}
    console.say(f"{model.name}, judged on {step.judged_on}")
    console.say(before_after_table(step.joints))
    say_equations("what was added, torque", added, console)
    for term, place in model.basis.slices():
        joint = model.joints[term.joint]
        if isinstance(term.effect, Curve) and (term.effect.name, joint) in of:
            console.paragraph(f"{joint}: {term.effect.words(model.coefficients[place])}", "  ")
    console.say()
    if effect.caution:
        console.note(f"{effect.name}: {effect.caution}")
    worst = [one.joint for one in added if not step.joints[one.joint].fell]
    if worst:
        console.note(
            f"the error on {', '.join(worst)} did not fall: on this data the effect is not missed"
        )
    before, after = number(step.error_before), number(step.error_after)
    console.say(f"error of all joints: {before} -> {after} N·m")
