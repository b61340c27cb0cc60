"""Motion, feedforward torque and hidden effects of the simulated arm."""

from argparse import Namespace
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lagrangian_ff.arm import JOINTS, Trajectory, exciting_trajectory, read_trajectory, simulate
from lagrangian_ff.arm.hidden import HIDDEN, HiddenEffect, Reference, Site, size, sized
from lagrangian_ff.arm.hidden.base import together
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
SIZED_SEED, SIZED_SECONDS = 0, 20.0
"""Effects are sized along this motion, so that every recording is of the same arm; s."""


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


@dataclass(frozen=True)
class Wanted:
    """An effect to hide, on a joint (0 to 5), of a size: its torque's rms over the joint's."""

    effect: HiddenEffect
    joint: int
    size: float


@dataclass(frozen=True)
class Hidden:
    """Hidden physics of the arm; `arm` is what `lagrangian_ff.arm.simulate` takes.

    Attributes:
        records: for JSON, one for each effect.
    """

    arm: dict[str, Any] = field(default_factory=dict)
    records: tuple[dict[str, Any], ...] = ()


def wanted(texts: Sequence[str]) -> list[Wanted]:
    """Return the effects that --hidden asks for.

    Raises:
        UserError: it is of another form, there is no such effect or joint, or it cannot be there.
    """
    asked = []
    for text in texts:
        place, colon, number = text.partition(":")
        name, at, joint = place.partition("@")
        try:
            share = float(number)
        except ValueError:
            colon = ""
        if not (at and colon):
            raise UserError(
                f"--hidden {text}: expected EFFECT@JOINT:SIZE, as in stribeck@joint_3:0.1"
            )
        if name not in HIDDEN:
            raise UserError(f"--hidden {text}: no effect '{name}'; there are {', '.join(HIDDEN)}")
        possible = [JOINTS[n] for n in HIDDEN[name].joints]
        if joint not in possible:
            raise UserError(f"--hidden {text}: {name} can be on {', '.join(possible)}")
        if not 0.0 < share <= 1.0:
            raise UserError(
                f"--hidden {text}: the size is the effect's torque over that of the joint, above 0 "
                "and at most 1"
            )
        asked.append(Wanted(HIDDEN[name], JOINTS.index(joint), share))
    return asked


def hidden(asked: Sequence[Wanted], recording: int) -> Hidden:
    """Size and build the hidden effects; those that depend on chance follow the recording's number.

    Raises:
        UserError: two effects need a load at the tool, of which there can be one.
    """
    if not asked:
        return Hidden()
    with progress_bar("sizing what is hidden") as progress:
        run = simulate(exciting_trajectory(SPEED, SIZED_SEED, SIZED_SECONDS), progress=progress)
    along = Reference.of(run)
    parts, records = [], []
    for number, one in enumerate(asked):
        site = Site(one.joint, number, recording, along)
        part, _ = sized(one.effect, site, one.size)
        parts.append(part)
        records.append(
            {
                "effect": one.effect.name,
                "joint": JOINTS[one.joint],
                "size": size(one.effect, part, site),
                "wanted": one.size,
                "physics": one.effect.physics,
                "facts": dict(part.facts),
            }
        )
    if sum(part.attached is not None for part in parts) > 1:
        raise UserError("--hidden: the arm can take up one load only; name one payload")
    return Hidden(together(parts), tuple(records))
