"""Designed motions: options of `excite`, the design, what is said of it, and what came of it."""

import json
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangian_ff import budget
from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console, progress_bar, table
from lagrangian_ff.errors import UserError
from lagrangian_ff.numbers import number

if TYPE_CHECKING:
    from argparse import _ActionsContainer

    from lagrangian_ff.arm import Trajectory
    from lagrangian_ff.arrays import Floats
    from lagrangian_ff.diagnosis import DiagnosisRun
    from lagrangian_ff.diagnosis.excite import Design, Limits, Outcome, Question
    from lagrangian_ff.diagnosis.excite.keeping import Clear
    from lagrangian_ff.identification import Model

BOUNDS = {
    "low": ("q_low", "RAD", "lowest position"),
    "high": ("q_high", "RAD", "highest position"),
    "speed": ("qd_max", "RAD/S", "highest speed"),
    "acceleration": ("qdd_max", "RAD/S2", "highest acceleration"),
    "jerk": ("jerk_max", "RAD/S3", "highest jerk"),
    "torque": ("tau_max", "NM", "highest torque, predicted by the model"),
}
"""Options that give a limit: the field of `Limits`, unit and meaning."""
TOLD = 8
"""Effects that the motion shows best, and those it will not show, that are listed."""


def add_questions(parser: ArgumentParser) -> None:
    """Declare the questions that a motion may be designed for."""
    group = parser.add_argument_group("a motion designed for a question")
    one = group.add_mutually_exclusive_group()
    name = "is this effect there, and none of its look-alikes instead?"
    one.add_argument("--for", dest="suspect", metavar="EFFECT@JOINT", help=name)
    two = "which of two is there?"
    one.add_argument("--between", nargs=2, metavar="EFFECT@JOINT", help=two)
    everything = "of all effects and bodies, what do the model's own data not show?"
    one.add_argument("--everything", action="store_true", help=everything)
    bodies = "which masses and inertias? With the least motion, to identify the arm"
    one.add_argument("--parameters", action="store_true", help=bodies)
    options.add_rows(group, (
        ("--size", float, "SHARE",
         "torque of the effects on the model's own data, over that of the joint (default: 0.05)"),
        ("--shape", list, "NAME=VALUE", "with --for: the effect's shape, if it is known"),
        ("--search", float, "SHARE", "of the usual search, which takes a minute (default: 1)"),
    ))  # fmt: skip


def add_limits(parser: ArgumentParser) -> None:
    """Declare limits and obstacles of a designed motion."""
    group = parser.add_argument_group("limits of a designed motion")
    for option, (_, unit, meaning) in BOUNDS.items():
        text = f"{meaning} (default: what the model's own data reached, less a twentieth)"
        options.add_list(group, f"--{option}", f"JOINT={unit}", text)
    add_shapes(group)


def add_shapes(group: "_ActionsContainer") -> None:
    """Declare the robot's description and obstacles."""
    options.add_rows(group, (
        ("--urdf", Path, "FILE",
         "the robot's description: its limits are kept too, and its collision shapes stay clear "
         "of each other and of obstacles (needs the extra urdf)"),
        ("--floor", float, "Z", "height of a floor, m"),
        ("--clearance", float, "M", "kept from obstacles and between links (default: 0.02)"),
    ))  # fmt: skip
    box = "an obstacle along the axes of the base: centre and edges, m; may be given several times"
    names = ("X", "Y", "Z", "SX", "SY", "SZ")
    group.add_argument(
        "--box", nargs=6, type=float, action="append", default=[], metavar=names, help=box
    )


def check(arguments: Namespace) -> None:
    """Raise UserError for options that do not go together."""
    flags = [getattr(arguments, name) or None for name in ("everything", "parameters")]
    asked = [arguments.suspect, arguments.between, arguments.what, *flags]
    if sum(one is not None for one in asked) != 1:
        raise UserError(
            "name one: an effect or a motion for a template, or --for, --between, --everything or "
            "--parameters"
        )
    own = ["size", "shape", "search", "urdf", "floor", "clearance", "box", *BOUNDS]
    given = [f"--{name}" for name in own if getattr(arguments, name) not in (None, [])]
    if arguments.what is not None:
        if given:
            raise UserError(f"{given[0]} is for a designed motion: give --for or another question")
        return
    if arguments.model is None:
        raise UserError("a designed motion needs --model, which predicts what it will show")
    if arguments.joint is not None:
        raise UserError("--joint is for a template: a question names its joints, as E@JOINT")
    if arguments.search is not None and not 0.0 < arguments.search <= 10.0:
        raise UserError(f"--search {arguments.search:g}: expected more than 0, and 10 at most")
    if arguments.shape and arguments.suspect is None:
        raise UserError("--shape goes with --for")
    if arguments.arm and arguments.urdf is not None:
        raise UserError("--arm has its own shapes and floor: leave --urdf out")
    check_shapes(arguments)


def check_shapes(arguments: Namespace) -> None:
    """Raise UserError for obstacles that cannot be, or are beside an arm without a shape."""
    if arguments.urdf is None and (arguments.box or arguments.floor is not None):
        raise UserError("--box and --floor need --urdf: without it the arm has no shape")
    if any(edge <= 0.0 for box in arguments.box for edge in box[3:]):
        raise UserError("--box: expected edges SX SY SZ above 0")


def designed(arguments: Namespace) -> "Design":
    """Return the motion that the arguments ask for."""
    from lagrangian_ff.diagnosis.excite import design
    from lagrangian_ff.diagnosis.excite.assumed import SIZE
    from lagrangian_ff.diagnosis.excite.climbing import USUAL
    from lagrangian_ff.diagnosis.excite.design import SECONDS, pose_for
    from lagrangian_ff.identification import Model

    model: Model = Model.load(arguments.model)
    question = _question(arguments)
    limits = _limits(arguments, model)
    usual = pose_for(question, model, limits)
    start = options.pose("--start", arguments.start, model.joints, usual)
    with ExitStack() as stack:
        clear = _clear(arguments, model, stack)
        progress = stack.enter_context(progress_bar("designing a motion"))
        return design(
            model,
            question,
            limits.around(start, arguments.reach),
            start=start,
            seconds=SECONDS if arguments.duration is None else arguments.duration,
            size=SIZE if arguments.size is None else arguments.size,
            clear=clear,
            effort=USUAL if arguments.search is None else USUAL.scaled(arguments.search),
            seed=arguments.seed,
            progress=progress,
        )


def _question(arguments: Namespace) -> "Question":
    from lagrangian_ff.diagnosis.excite import Between, Everything, For, Parameters, Suspect

    if arguments.suspect is not None:
        suspect = Suspect.parse(arguments.suspect)
        shape = options.assignments("--shape", arguments.shape)
        return For(Suspect(suspect.effect, suspect.joint, shape))
    if arguments.between is not None:
        first, second = map(Suspect.parse, arguments.between)
        return Between(first, second)
    return Parameters() if arguments.parameters else Everything()


def _limits(arguments: Namespace, model: "Model") -> "Limits":
    from dataclasses import replace

    import numpy as np

    from lagrangian_ff.diagnosis.excite import limits_of, urdf_limits

    limits = limits_of(model)
    if arguments.arm:
        from lagrangian_ff.cli.common.arm_motion import arm_limits

        limits = arm_limits(model.joints)
    if arguments.urdf is not None:
        limits = urdf_limits(arguments.urdf, model.joints, limits)
    for option, (field, _, _) in BOUNDS.items():
        if texts := getattr(arguments, option):
            usual = getattr(limits, field)
            usual = np.full(len(model.joints), np.inf) if usual is None else usual
            given = options.pose(f"--{option}", texts, model.joints, usual)
            limits = replace(limits, **{field: given})
    return limits


def _clear(arguments: Namespace, model: "Model", stack: ExitStack) -> "Clear | None":
    if arguments.arm:
        from lagrangian_ff.cli.common.arm_motion import arm_clear

        return stack.enter_context(arm_clear(model.joints, _margin(arguments)))
    if arguments.urdf is None:
        return None
    return clearance(arguments, model.joints, model.data.q)


def _margin(arguments: Namespace) -> float:
    from lagrangian_ff.diagnosis.excite.clearance import MARGIN

    return MARGIN if arguments.clearance is None else float(arguments.clearance)


def clearance(arguments: Namespace, joints: "Sequence[str]", seen: "Floats") -> "Clear":
    """Return what says whether a path touches the robot itself or an obstacle, from its URDF.

    Args:
        joints: N names.
        seen: (M, N) rad, poses that the arm has been in.

    Raises:
        ModelError: see `Clearance.of`.
    """
    from lagrangian_ff.diagnosis.excite import Box, Clearance, floor_at

    obstacles = [Box((x, y, z), (a, b, c)) for x, y, z, a, b, c in arguments.box]
    if arguments.floor is not None:
        obstacles.append(floor_at(arguments.floor))
    return Clearance.of(arguments.urdf, joints, seen, obstacles, _margin(arguments))


def trajectory_of(design: "Design") -> "Trajectory":
    """Return the motion as a trajectory."""
    from lagrangian_ff.arm import Trajectory

    return Trajectory(*design.reference, design.joints)


def record_of(design: "Design") -> dict[str, Any]:
    """Return the design as JSON holds it."""
    from lagrangian_ff.diagnosis.excite import design_record

    return design_record(design)


def say(design: "Design", record: dict[str, Any], console: Console) -> None:
    """Print what a design is expected to show, what it will not, and how far it goes."""
    from lagrangian_ff.diagnosis import thresholds
    from lagrangian_ff.diagnosis.excite import Parameters

    size = design.expected[0].size if design.expected else 0.0
    console.say(f"{record['question']} {record['seconds']:.1f} s, climbed from {design.begun}")
    if not design.finished:
        console.note("interrupted: this is the best motion that was found until then")
    if design.beyond:
        console.note(
            f"{', '.join(design.beyond)} go farther or faster than the model has seen: torques and "
            "gains are a guess there"
        )
    of_bodies = isinstance(design.question, Parameters)
    words = f"to decide it, for an effect of {size:.0%} of its joint's torque"
    words = "about the rigid bodies" if of_bodies else words
    console.say(f"expected: {number(design.nats)} nats {words}")
    if design.nats < thresholds.USED.floor and not design.beyond and not of_bodies:
        console.note(
            "that is too little for a claim within what the model has seen: where the arm may move "
            "faster or farther, allow it (--speed, --acceleration, --jerk, --low, --high)"
        )
    rows = [
        [one["effect"], one["joint"], number(one["nats"]), number(one["torque"])]
        for one in record["expected"][:TOLD]
    ]
    console.say(["", "what it will show best, against the model as it is"])
    console.say(table(["effect", "joint", "nats", "rms [N·m]"], rows))
    hidden: dict[str, list[str]] = {}
    for one in record["not_shown"]:
        hidden.setdefault(one["effect"], []).append(one["joint"])
    if hidden:
        floor = thresholds.USED.floor
        every = len(design.joints)
        whole = [name for name, joints in hidden.items() if len(joints) == every]
        console.paragraph(
            f"not shown (below {floor:g} nats) on any joint: {', '.join(whole) or '-'}"
        )
        for joint in design.joints:
            names = [n for n, joints in hidden.items() if joint in joints and n not in whole]
            if names:
                console.paragraph(f"{joint}: {', '.join(names)}", "  on ", "     ")
    console.say(["", "share of its limits that it takes"])
    names = list(record["used"])
    shares = [
        [joint, *(f"{record['used'][name][joint]:.2f}" for name in names)]
        for joint in design.joints
    ]
    console.say(table(["joint", *names], shares))
    console.say()


Promise = dict[str, Any] | None
"""The JSON of a design; None if none was given."""


def promised(path: Path | None) -> Promise:
    """Return the design in a file.

    Raises:
        UserError: it is not what `excite --json` writes of a designed motion.
    """
    if path is None:
        return None
    from lagrangian_ff.diagnosis.excite import outcomes

    try:
        design: dict[str, Any] = json.loads(budget.text_of(path, UserError))
        outcomes(design, {"findings": []})
    except OSError as error:
        raise UserError(f"--expected {path}: {error.strerror or error}") from None
    except (ValueError, RecursionError):
        raise UserError(
            f"--expected {path}: expected the file that lagrangian_ff excite --for, or another "
            "question, writes with --json"
        ) from None
    return design


def _outcomes(design: Promise, run: "DiagnosisRun") -> "tuple[Outcome, ...]":
    from lagrangian_ff.diagnosis import run_record
    from lagrangian_ff.diagnosis.excite import outcomes

    return () if design is None else outcomes(design, run_record(run))


def outcome_record(design: Promise, run: "DiagnosisRun") -> dict[str, Any]:
    """Return what came of a design as JSON; nothing without one."""
    found = [asdict(one) for one in _outcomes(design, run)]
    return {} if design is None else {"outcomes": found}


def say_outcomes(design: Promise, run: "DiagnosisRun", console: Console) -> None:
    """Print what came of a design beside what it promised; nothing without one."""
    if design is None:
        return
    rows = [
        [one.effect, one.joint, number(one.ratio), number(one.promised), number(one.gained)]
        for one in _outcomes(design, run)
    ]
    console.say(["", "what the design of this motion promised of what was found"])
    if rows:
        header = ["effect", "joint", "size over that asked for", "promised nats", "gained nats"]
        console.say(table(header, rows))
    else:
        console.say("  it spoke of nothing that was found")
