"""`excite`: the motion to record next."""

from argparse import ArgumentParser, Namespace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangian_ff.cli.common import designed, options
from lagrangian_ff.cli.common.console import Console, progress_bar, table
from lagrangian_ff.cli.common.joint_trajectory import joint_trajectory_yaml
from lagrangian_ff.cli.common.outputs import check_outputs, whole, write_record
from lagrangian_ff.errors import UserError
from lagrangian_ff.numbers import number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lagrangian_ff.arm import Trajectory


NAME = "excite"
SUMMARY = "make the motion that shows an effect, or settles a doubt"
USAGE = "EFFECT|MOTION|QUESTION [--model MODEL] [--arm] --output FILE [options]"
DESCRIPTION = """\
Makes the motion to record next, as a trajectory: a template, by the name of an effect that is to be
shown or by its own; or a motion designed for a question, so that what it is expected to say, in
nats of evidence, is as much as the limits allow. It is smooth, begins and ends at rest, and stays
within the range that a model was identified on, or within the limits of the simulated arm, clear
of itself and the floor. A designed motion keeps limits of jerk and torque too, clear of obstacles,
and says beforehand what it will show; with diagnose --expected that is compared with what it
showed."""
EPILOG = """\
examples:
  lagrangian_ff excite stribeck --joint joint_2 --model model.npz --output creep.csv
  lagrangian_ff excite speeds --joint joint_3 --arm --output speeds.csv
  lagrangian_ff simulate --trajectory speeds.csv --output speeds_bag
  lagrangian_ff excite "one by one" --model model.npz --output pairs.yaml
  ros2 topic pub --once /joint_trajectory_controller/joint_trajectory \\
      trajectory_msgs/msg/JointTrajectory --stdin < pairs.yaml
  lagrangian_ff excite --for stribeck@joint_2 --model model.npz --output d.csv --json d.json
  lagrangian_ff excite --between backlash@elbow hysteresis@elbow --model model.npz \\
      --urdf robot.urdf --floor 0 --box 0.6 0 0.4  0.3 0.8 0.05 --output d.yaml
  lagrangian_ff excite --everything --model model.npz --output d.csv
  lagrangian_ff excite --parameters --model model.npz --output masses.csv

the templates:
  exciting     all joints through their ranges at once, slow and fast
  speeds       constant speeds from creeping to the limit, both ways
  slow sweep   the whole range slowly both ways, then creeping
  reversals    strokes of 0.1 mrad to 0.15 rad at two speeds
  chirp        small and faster and faster
  one by one   each joint alone, then pairs with and against each other
  warm-up      the same short motion for minutes
  payloads     one motion to be done with and without a load

On a real arm: bring it to the start pose first, and make sure that the way is clear. A model knows
how far each joint went, not which poses touch."""


def add_arguments(parser: ArgumentParser) -> None:
    what = "a template: an effect to be shown, or a motion by its name"
    parser.add_argument("what", nargs="?", metavar="EFFECT|MOTION", help=what)
    joint = "the joint that a template looks at (default: all, one after the other)"
    options.add_rows(parser, [("--joint", str, "J", joint)])
    designed.add_questions(parser)
    where = [
        ("--model", Path, "MODEL.npz",
         "no farther and faster than this model knows; a designed motion needs a model"),
        ("--arm", bool, "", "what the simulated arm can do without contact"),
    ]  # fmt: skip
    options.add_rows(parser.add_argument_group("where it may go"), where)
    designed.add_limits(parser)
    output = "a .csv for simulate and feedforward, or a .yaml (trajectory_msgs/JointTrajectory)"
    parser.add_argument("--output", required=True, type=Path, metavar="FILE", help=output)
    options.add_rows(parser, (
        ("--start", list, "JOINT=RAD",
         "where it begins, and holds the other joints (default: a pose that loads the joint)"),
        ("--duration", float, "SECONDS", "about how long (default: of a designed motion 20)"),
        ("--reach", float, "SHARE",
         "share of the way from the start to the limits, 0 to 1 (default: 1)"),
        ("--seed", int, "", "seed of the random numbers (default: 0)"),
    ))  # fmt: skip
    parser.set_defaults(reach=1.0, seed=0)
    options.add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    _check_arguments(arguments)
    options.load_own_effects(arguments, console)
    if arguments.what is None:
        return _designed(arguments, console)
    motion = _motion_of(arguments.what)
    trajectory = _of_arm(arguments, motion) if arguments.arm else _of_model(arguments, motion)
    title = f"{motion}, {arguments.joint or 'all joints'}, {trajectory.duration:.0f} s"
    _write(arguments.output, trajectory, f"lagrangian_ff excite: {title}")
    record = _record(arguments, motion, trajectory)
    write_record(arguments.json, record)
    _say(arguments, record, console)
    return 0


def _designed(arguments: Namespace, console: Console) -> int:
    found = designed.designed(arguments)
    trajectory = designed.trajectory_of(found)
    record = designed.record_of(found) | {
        "joints": _by_joint(trajectory),
        "output": str(arguments.output),
    }
    _write(arguments.output, trajectory, f"lagrangian_ff excite: {record['question']}")
    write_record(arguments.json, record)
    designed.say(found, record, console)
    _say_joints(record, console)
    console.say(f"saved: {arguments.output}")
    if arguments.urdf is None and not arguments.arm:
        _note_blind(console, "Give --urdf to have it checked")
    _say_next(arguments, console)
    return 0


def _check_arguments(arguments: Namespace) -> None:
    if arguments.output.suffix not in (".csv", ".yaml"):
        raise UserError(f"--output {arguments.output}: expected a name that ends in .csv or .yaml")
    check_outputs(arguments, [arguments.model, arguments.urdf])
    if not 0.0 < arguments.reach <= 1.0:
        raise UserError(f"--reach {arguments.reach:g}: expected more than 0, and 1 at most")
    options.check_seed(arguments)
    designed.check(arguments)
    if arguments.arm and find_spec("pybullet") is None:
        raise UserError("the simulated arm needs PyBullet: pip install pybullet")
    if arguments.what is not None and arguments.arm == (arguments.model is not None):
        raise UserError("a template needs --model or --arm, one of them: they say where it may go")


def _motion_of(name: str) -> str:
    """Return the motion of this name, or the one that shows this effect.

    Raises:
        UserError: there is neither.
    """
    from lagrangian_ff.diagnosis.excite import NEXT_MOTIONS

    plain = {motion.replace(" ", "-"): motion for motion in NEXT_MOTIONS}
    asked = name.strip().lower().replace(" ", "-").replace("_", "-")
    if asked in plain:
        return plain[asked]
    try:
        return options.effect_named(name).motion
    except UserError as error:
        raise UserError(f"{error}; the motions are {', '.join(NEXT_MOTIONS)}") from error


def _of_arm(arguments: Namespace, motion: str) -> "Trajectory":
    import numpy as np

    from lagrangian_ff.arm import HOME, JOINTS
    from lagrangian_ff.cli.common.arm_motion import clear_motion

    _check_joint(arguments.joint, JOINTS, "the simulated arm")
    start = options.pose("--start", arguments.start, JOINTS, np.array(HOME))
    with progress_bar("finding a motion within limits and free of contact") as progress:
        size = arguments.duration, arguments.reach, arguments.seed
        held = start if arguments.start else None
        return clear_motion(motion, arguments.joint, held, *size, progress)


def _of_model(arguments: Namespace, motion: str) -> "Trajectory":
    from lagrangian_ff.arm import Trajectory
    from lagrangian_ff.diagnosis.excite import Limits, excite, seen_pose
    from lagrangian_ff.identification import Model

    model: Model = Model.load(arguments.model)
    joints, joint = model.joints, arguments.joint
    _check_joint(joint, joints, str(arguments.model))
    limits = Limits.within(model.range, joints)
    start = options.pose("--start", arguments.start, joints, seen_pose(model, joint, limits))
    near, duration, seed = limits.around(start, arguments.reach), arguments.duration, arguments.seed
    found = excite(motion, joints, near, joint=joint, start=start, duration=duration, seed=seed)
    return Trajectory(found.time, found.q, found.qd, found.qdd, joints)


def _check_joint(joint: str | None, joints: "Sequence[str]", whose: str) -> None:
    if joint is not None and joint not in joints:
        raise UserError(f"--joint {joint}: {whose} has the joints {', '.join(joints)}")


def _write(path: Path, trajectory: "Trajectory", title: str) -> None:
    """Write the file."""
    from lagrangian_ff.arm import write_trajectory

    with whole(path) as made:
        if path.suffix == ".csv":
            write_trajectory(made, trajectory)
        else:
            made.write_text(joint_trajectory_yaml(trajectory, title), encoding="utf-8")


def _record(arguments: Namespace, motion: str, trajectory: "Trajectory") -> dict[str, Any]:
    from lagrangian_ff.diagnosis.excite import NEXT_MOTIONS

    chosen = NEXT_MOTIONS[motion]
    return {
        "asked": arguments.what,
        "motion": motion,
        "joint": arguments.joint,
        "seconds": trajectory.duration,
        "meaning": chosen.meaning,
        "by_hand": chosen.by_hand,
        "joints": _by_joint(trajectory),
        "output": str(arguments.output),
    }


def _by_joint(trajectory: "Trajectory") -> dict[str, dict[str, float]]:
    q, speed, hardness = trajectory.q, abs(trajectory.qd), abs(trajectory.qdd)
    columns = {
        "start": q[0],
        "low": q.min(axis=0),
        "high": q.max(axis=0),
        "fastest": speed.max(axis=0),
        "hardest": hardness.max(axis=0),
    }
    return {
        name: {key: float(values[n]) for key, values in columns.items()}
        for n, name in enumerate(trajectory.joints)
    }


def _say(arguments: Namespace, record: dict[str, Any], console: Console) -> None:
    asked = "" if record["motion"] == record["asked"] else f", for {record['asked']}"
    who = record["joint"] or "all joints"
    console.say(f"{record['motion']}{asked}: {who}, {record['seconds']:.0f} s")
    console.paragraph(record["meaning"], "  ", "  ")
    console.paragraph(f"you: {record['by_hand']}", "  ", "       ")
    _say_joints(record, console)
    console.say(f"saved: {arguments.output}")
    if not arguments.arm:
        _note_blind(console, "Begin at the start pose, and slowly")
    _say_next(arguments, console)


def _say_joints(record: dict[str, Any], console: Console) -> None:
    rows = [
        [name, *(number(one[key]) for key in ("start", "low", "high", "fastest"))]
        for name, one in record["joints"].items()
    ]
    header = ["joint", "start [rad]", "lowest [rad]", "highest [rad]", "fastest [rad/s]"]
    console.say(table(header, rows))


def _note_blind(console: Console, advice: str) -> None:
    console.note(
        "each joint stays where the model has seen it; whether the arm then touches itself or "
        f"what is near, the model cannot know. {advice}"
    )


def _say_next(arguments: Namespace, console: Console) -> None:
    if arguments.output.suffix == ".yaml":
        node = "arm" if arguments.arm else "joint_trajectory_controller"
        console.say(f"next: ros2 topic pub --once /{node}/joint_trajectory \\")
        console.say(f"        trajectory_msgs/msg/JointTrajectory --stdin < {arguments.output}")
    elif arguments.arm:
        console.say(f"next: lagrangian_ff simulate --trajectory {arguments.output} --output BAG")
