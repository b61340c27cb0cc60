"""`excite`: the motion to record next."""

from argparse import ArgumentParser, Namespace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console, progress_bar, table
from lagrangian_ff.cli.common.outputs import check_outputs, whole, write_record
from lagrangian_ff.errors import UserError
from lagrangian_ff.numbers import number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lagrangian_ff.arm import Trajectory
    from lagrangian_ff.arrays import Floats, Ints


NAME = "excite"
SUMMARY = "make the motion that shows an effect, or settles a doubt"
USAGE = "EFFECT|MOTION (--model MODEL | --arm) --output FILE [options]"
DESCRIPTION = """\
Makes the motion to record next, as a trajectory: by the name of an effect that is to be shown, or
by its own name. It is smooth, begins and ends at rest, and stays within the range that a model was
identified on, or within the limits of the simulated arm, clear of itself and the floor."""
EPILOG = """\
examples:
  lagrangian_ff excite stribeck --joint joint_2 --model model.npz --output creep.csv
  lagrangian_ff excite speeds --joint joint_3 --arm --output speeds.csv
  lagrangian_ff simulate --trajectory speeds.csv --output speeds_bag
  lagrangian_ff excite "one by one" --model model.npz --output pairs.yaml
  ros2 topic pub --once /joint_trajectory_controller/joint_trajectory \\
      trajectory_msgs/msg/JointTrajectory --stdin < pairs.yaml

the motions:
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

CLOSE = 5e-6
"""The largest error of the quintics between the points of a message, rad."""
_DIGITS = 7


def add_arguments(parser: ArgumentParser) -> None:
    what = [
        ("what", str, "EFFECT|MOTION", "an effect to be shown, or a motion by its name"),
        ("--joint", str, "J", "the joint to look at (default: all, one after the other)"),
    ]
    options.add_rows(parser, what)
    where = [
        ("--model", Path, "MODEL.npz", "no farther and faster than this model knows"),
        ("--arm", bool, "", "what the simulated arm can do without contact"),
    ]
    group = parser.add_argument_group("where it may go").add_mutually_exclusive_group(required=True)
    options.add_rows(group, where)
    output = "a .csv for simulate and feedforward, or a .yaml (trajectory_msgs/JointTrajectory)"
    parser.add_argument("--output", required=True, type=Path, metavar="FILE", help=output)
    options.add_rows(parser, (
        ("--start", list, "JOINT=RAD",
         "where it begins, and holds the other joints (default: a pose that loads the joint)"),
        ("--duration", float, "SECONDS", "about how long"),
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
    motion = _motion_of(arguments.what)
    trajectory = _of_arm(arguments, motion) if arguments.arm else _of_model(arguments, motion)
    title = f"{motion}, {arguments.joint or 'all joints'}, {trajectory.duration:.0f} s"
    _write(arguments.output, trajectory, f"lagrangian_ff excite: {title}")
    record = _record(arguments, motion, trajectory)
    write_record(arguments.json, record)
    _say(arguments, record, console)
    return 0


def _check_arguments(arguments: Namespace) -> None:
    if arguments.output.suffix not in (".csv", ".yaml"):
        raise UserError(f"--output {arguments.output}: expected a name that ends in .csv or .yaml")
    check_outputs(arguments, [arguments.model])
    if not 0.0 < arguments.reach <= 1.0:
        raise UserError(f"--reach {arguments.reach:g}: expected more than 0, and 1 at most")
    options.check_seed(arguments)
    if arguments.arm and find_spec("pybullet") is None:
        raise UserError("the simulated arm needs PyBullet: pip install pybullet")


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
    start = _start(arguments.start, JOINTS, np.array(HOME)) if arguments.start else None
    with progress_bar("finding a motion within limits and free of contact") as progress:
        size = arguments.duration, arguments.reach, arguments.seed
        return clear_motion(motion, arguments.joint, start, *size, progress)


def _of_model(arguments: Namespace, motion: str) -> "Trajectory":
    from lagrangian_ff.arm import Trajectory
    from lagrangian_ff.diagnosis.excite import Limits, excite, seen_pose
    from lagrangian_ff.identification import Model

    model: Model = Model.load(arguments.model)
    joints, joint = model.joints, arguments.joint
    _check_joint(joint, joints, str(arguments.model))
    limits = Limits.within(model.range, joints)
    start = _start(arguments.start, joints, seen_pose(model, joint, limits))
    near, duration, seed = limits.around(start, arguments.reach), arguments.duration, arguments.seed
    found = excite(motion, joints, near, joint=joint, start=start, duration=duration, seed=seed)
    return Trajectory(found.time, found.q, found.qd, found.qdd, joints)


def _check_joint(joint: str | None, joints: "Sequence[str]", whose: str) -> None:
    if joint is not None and joint not in joints:
        raise UserError(f"--joint {joint}: {whose} has the joints {', '.join(joints)}")


def _start(texts: "list[str]", joints: "Sequence[str]", usual: "Floats") -> "Floats":
    """Return (N,) rad, the usual pose with the positions that the user gives."""
    given = options.assignments("--start", texts)
    unknown = [name for name in given if name not in joints]
    if unknown:
        raise UserError(f"--start: no joint {', '.join(unknown)}; there are {', '.join(joints)}")
    pose = usual.copy()
    for name, value in given.items():
        pose[list(joints).index(name)] = value
    return pose


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
    q, speed, hardness = trajectory.q, abs(trajectory.qd), abs(trajectory.qdd)
    columns = {
        "start": q[0],
        "low": q.min(axis=0),
        "high": q.max(axis=0),
        "fastest": speed.max(axis=0),
        "hardest": hardness.max(axis=0),
    }
    return {
        "asked": arguments.what,
        "motion": motion,
        "joint": arguments.joint,
        "seconds": trajectory.duration,
        "meaning": chosen.meaning,
        "by_hand": chosen.by_hand,
        "joints": {
            name: {key: float(values[n]) for key, values in columns.items()}
            for n, name in enumerate(trajectory.joints)
        },
        "output": str(arguments.output),
    }


def _say(arguments: Namespace, record: dict[str, Any], console: Console) -> None:
    asked = "" if record["motion"] == record["asked"] else f", for {record['asked']}"
    who = record["joint"] or "all joints"
    console.say(f"{record['motion']}{asked}: {who}, {record['seconds']:.0f} s")
    console.paragraph(record["meaning"], "  ", "  ")
    console.paragraph(f"you: {record['by_hand']}", "  ", "       ")
    rows = [
        [name, *(number(one[key]) for key in ("start", "low", "high", "fastest"))]
        for name, one in record["joints"].items()
    ]
    header = ["joint", "start [rad]", "lowest [rad]", "highest [rad]", "fastest [rad/s]"]
    console.say(table(header, rows))
    console.say(f"saved: {arguments.output}")
    if not arguments.arm:
        console.note(
            "each joint stays where the model has seen it; whether the arm then touches itself or "
            "what is near, the model cannot know. Begin at the start pose, and slowly"
        )
    if arguments.output.suffix == ".yaml":
        node = "arm" if arguments.arm else "joint_trajectory_controller"
        console.say(f"next: ros2 topic pub --once /{node}/joint_trajectory \\")
        console.say(f"        trajectory_msgs/msg/JointTrajectory --stdin < {arguments.output}")
    elif arguments.arm:
        console.say(f"next: lagrangian_ff simulate --trajectory {arguments.output} --output BAG")


def joint_trajectory_yaml(trajectory: "Trajectory", title: str) -> str:
    """Return the message as `ros2 topic pub` takes it; the title becomes a comment.

    Controllers that get positions, velocities and accelerations follow quintics between the
    points, so that long smooth parts need few.
    """
    lines = [f"# {title}", f"joint_names: [{', '.join(trajectory.joints)}]", "points:"]
    for k in _points(trajectory).tolist():
        nanoseconds = round((trajectory.time[k] - trajectory.time[0]) * 1e9)
        seconds, rest = divmod(nanoseconds, 1_000_000_000)
        for mark, label, values in (
            ("-", "positions", trajectory.q[k]),
            (" ", "velocities", trajectory.qd[k]),
            (" ", "accelerations", trajectory.qdd[k]),
        ):
            lines.append(f"{mark} {label}: [{', '.join(map(_number, values.tolist()))}]")
        lines.append(f"  time_from_start: {{sec: {seconds}, nanosec: {rest}}}")
    return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    text = f"{value:.{_DIGITS}g}" if abs(value) > 1e-9 else "0.0"
    # ROS takes 1 for a whole number and refuses it; YAML takes 1e-05 for a text.
    if "e" in text:
        text = f"{value:.12f}".rstrip("0")
    return text if "." in text else f"{text}.0"


def _points(trajectory: "Trajectory") -> "Ints":
    """Return (P,) the points to keep: pieces of the motion are halved until the quintics fit."""
    import numpy as np

    kept = [0]
    waiting = [(0, len(trajectory) - 1)] if len(trajectory) > 1 else []
    while waiting:
        first, last = waiting.pop()
        if last - first > 1 and not _fits(trajectory, first, last):
            middle = (first + last) // 2
            waiting += [(middle, last), (first, middle)]
        else:
            kept.append(last)
    return np.array(kept, dtype=np.int64)


def _fits(trajectory: "Trajectory", first: int, last: int) -> bool:
    import numpy as np

    from lagrangian_ff.arm import Trajectory

    ends, inner = [first, last], slice(first, last + 1)
    t = trajectory
    quintic = Trajectory(t.time[ends], t.q[ends], t.qd[ends], t.qdd[ends], t.joints)
    q, _, _ = quintic.sample(trajectory.time[inner])
    return bool(np.abs(q - trajectory.q[inner]).max() <= CLOSE)
