"""What the simulated arm is driven with: a motion and a feedforward torque."""

from argparse import Namespace
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.leaving import leaving
from lagrangian_ff.cli.common.progress import progress_bar
from lagrangian_ff.errors import ModelError, UserError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from lagrangian_ff.arm import Trajectory
    from lagrangian_ff.arm.simulation import Feedforward

    Floats = NDArray[np.float64]
    Torque = Callable[[Floats, Floats, Floats], Floats]

SPEED = 5
"""Of an exciting trajectory, where the user gives none."""
SAME_MOTION = 1e-3  # rad


def motion_file(arguments: Namespace) -> Path | None:
    """The CSV that holds the motion, None where one is to be made; a torque CSV holds it too."""
    if arguments.trajectory is not None:
        return Path(arguments.trajectory)
    asked = arguments.speed is not None or arguments.duration is not None
    if not asked and arguments.feedforward.endswith(".csv"):
        return Path(arguments.feedforward)
    return None


def motion_of(path: Path | None, arguments: Namespace, console: Console) -> "Trajectory":
    """The motion of a file, or an exciting one.

    Raises:
        ArmError: the file cannot be used, or no such motion was found.
    """
    from lagrangian_ff.arm import exciting_trajectory, read_trajectory

    if path is not None:
        console.note(f"the motion is that of {path}", "")
        trajectory = read_trajectory(path)
        for note in trajectory.notes:
            console.note(note, "")
        return trajectory
    with progress_bar("finding a motion within limits and free of collision"):
        return exciting_trajectory(arguments.speed or SPEED, arguments.seed, arguments.duration)


def torque_of(name: str, trajectory: "Trajectory", console: Console) -> "Feedforward":
    """The torque to add, as `lagrangian_ff.arm.simulate` takes it.

    Raises:
        UserError: the file holds no torque of this arm on this motion.
    """
    if name == "none":
        return None
    if name == "true":
        return "true"
    path = Path(name)
    if path.suffix == ".csv":
        return _of_csv(path, trajectory)
    return _of_model(path, trajectory, console)


def _of_csv(path: Path, trajectory: "Trajectory") -> "Floats":
    from lagrangian_ff.arm import read_trajectory

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


def _of_model(path: Path, trajectory: "Trajectory", console: Console) -> "Torque":
    from lagrangian_ff.arm import JOINTS
    from lagrangian_ff.identification import Model

    model = Model.load(path)
    if set(model.joints) != set(JOINTS):
        raise ModelError(
            f"{path} is a model of the joints {', '.join(model.joints)}; the simulated arm has "
            f"{', '.join(JOINTS)}"
        )
    motion = trajectory.select(model.joints)
    away = leaving(model, motion.time, (motion.q, motion.qd, motion.qdd))
    if away.share > 0.0:
        console.note(
            f"{away.share:.1%} of the motion lies outside what {path} was identified on "
            f"({away.worst}): there it guesses",
            "",
        )
    to_model = [JOINTS.index(name) for name in model.joints]
    to_arm = [model.joints.index(name) for name in JOINTS]

    def torque(q: "Floats", qd: "Floats", qdd: "Floats") -> "Floats":
        return model.predict(q[:, to_model], qd[:, to_model], qdd[:, to_model])[:, to_arm]

    return torque
