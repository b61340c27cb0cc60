"""Motion and feedforward torque of the simulated arm."""

from argparse import Namespace
from pathlib import Path

from lagrangian_ff.arm import JOINTS, Trajectory, exciting_trajectory, read_trajectory
from lagrangian_ff.arm.simulation import Feedforward, Torque
from lagrangian_ff.arrays import Floats
from lagrangian_ff.cli.common.console import Console, progress_bar
from lagrangian_ff.cli.common.sources import out_of_range
from lagrangian_ff.errors import ModelError, UserError
from lagrangian_ff.identification import Model

SPEED = 5
"""The speed of an exciting trajectory if the user gives none."""
SAME_MOTION = 1e-3
"""Positions of one motion differ by no more than this, rad."""


def motion_file(arguments: Namespace) -> Path | None:
    """Return the CSV that holds the motion, as a torque CSV does; None if one is to be made."""
    if arguments.trajectory is not None:
        return Path(arguments.trajectory)
    asked = arguments.speed is not None or arguments.duration is not None
    if not asked and arguments.feedforward.endswith(".csv"):
        return Path(arguments.feedforward)
    return None


def motion_of(path: Path | None, arguments: Namespace, console: Console) -> Trajectory:
    """Return the motion of a file, or an exciting one.

    Raises:
        ArmError: the file cannot be used, or no such motion was found.
    """
    if path is not None:
        console.note(f"the motion is that of {path}")
        trajectory = read_trajectory(path)
        for note in trajectory.notes:
            console.note(note)
        return trajectory
    with progress_bar("finding a motion within limits and free of collision"):
        return exciting_trajectory(arguments.speed or SPEED, arguments.seed, arguments.duration)


def torque_of(name: str, trajectory: Trajectory, console: Console) -> Feedforward:
    """Return the torque to add, as `lagrangian_ff.arm.simulate` takes it.

    Raises:
        UserError: the file holds no torque of this arm on this motion.
    """
    if name == "none":
        return None
    if name == "true":
        return "true"
    if name.endswith(".csv"):
        return _of_csv(Path(name), trajectory)
    return _of_model(Path(name), trajectory, console)


def _of_csv(path: Path, trajectory: Trajectory) -> Floats:
    given = read_trajectory(path)
    if given.effort is None:
        raise UserError(
            f"{path}: no columns effort/<joint>; make them with lagrangian_ff feedforward"
        )
    missing = [joint for joint in trajectory.joints if joint not in given.joints]
    if missing:
        raise UserError(f"{path}: holds no torque of {', '.join(missing)}")
    given = given.select(trajectory.joints)
    apart = abs(given.sample(trajectory.time)[0] - trajectory.q).max(axis=1)
    if apart.max() > SAME_MOTION:
        first = float(trajectory.time[(apart > SAME_MOTION).argmax()])
        raise UserError(
            f"{path}: is the torque of another motion: from {first:.3f} s its positions are not "
            f"those of the trajectory (up to {apart.max():.3g} rad apart); compute it for this one"
        )
    return given.effort_at(trajectory.time)


def _of_model(path: Path, trajectory: Trajectory, console: Console) -> Torque:
    model = Model.load(path)
    if set(model.joints) != set(JOINTS):
        raise ModelError(
            f"{path} is a model of the joints {', '.join(model.joints)}; the simulated arm has "
            f"{', '.join(JOINTS)}"
        )
    motion = trajectory.select(model.joints)
    away = out_of_range(model, motion.time, (motion.q, motion.qd, motion.qdd))
    away.warn("motion", str(path), ": there it guesses", console)
    to_model = [JOINTS.index(name) for name in model.joints]
    to_arm = [model.joints.index(name) for name in JOINTS]

    def torque(q: Floats, qd: Floats, qdd: Floats) -> Floats:
        return model.predict(q[:, to_model], qd[:, to_model], qdd[:, to_model])[:, to_arm]

    return torque
