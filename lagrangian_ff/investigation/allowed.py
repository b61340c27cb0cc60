"""What a careful user allows an arm: limits from its URDF, or from a file of joint limits."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
import yaml

from lagrangian_ff import budget
from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.excite import Limits, urdf_limits
from lagrangian_ff.errors import ModelError, UserError
from lagrangian_ff.kernels.rigid.robot import FIXED, joint_ends, urdf_joints

SPEED = 0.5
"""Share of the highest speeds that motions may take."""
UNTIL_FAST = 0.4
"""s in which a joint may reach its speed, where no acceleration is given."""
TORQUE = 0.85
"""Share of the motors' torque that a designed motion may take."""
FIELDS = {
    "q_low": "min_position",
    "q_high": "max_position",
    "qd_max": "max_velocity",
    "qdd_max": "max_acceleration",
    "jerk_max": "max_jerk",
    "tau_max": "max_effort",
}
"""Names of the limits in a file, those of MoveIt's joint_limits.yaml."""
OPTIONAL = ("qdd_max", "jerk_max", "tau_max")


def arm_names(
    heard: Sequence[str], taken: Sequence[str], urdf: Path | None, file: Path | None
) -> tuple[str, ...]:
    """Return the joints of an arm, base to tool, where the user does not name them.

    They are those of the file of limits, else of the URDF, that the controller takes. Where it is
    not known what that takes, what comes behind a fork of the URDF is left out: fingers.

    Args:
        heard: joints whose states are heard of.
        taken: joints of the controller; empty if it does not say.
        urdf, file: as in `allowed`.

    Raises:
        UserError: a file is of another form, or none of the joints is heard of or taken.
    """
    if file is not None:
        names, source = file_names(file), file
    elif urdf is not None:
        names, source = urdf_names(urdf, heard, forks=bool(taken)), urdf
    else:
        return ()
    if taken and not (names := tuple(name for name in names if name in taken)):
        raise UserError(f"{source}: the controller takes none of its joints: {', '.join(taken)}")
    return names


def urdf_names(path: Path, heard: Sequence[str], *, forks: bool = False) -> tuple[str, ...]:
    """Return the joints of a URDF that move by themselves and are heard of, base to tool.

    Args:
        heard: joints.
        forks: whether to go on where the arm forks; without, all of what forks at its base.

    Raises:
        ModelError: the file is no URDF, or none of its joints is heard of.
    """
    joints = urdf_joints(path)
    names = joints if forks else _trunk(joints) or joints
    found = tuple(
        name
        for name in names
        if joints[name].get("type") != FIXED
        and joints[name].find("mimic") is None
        and name in heard
    )
    if not found:
        raise ModelError(f"{path}: none of its joints is heard of; heard: {', '.join(heard)}")
    return found


def _trunk(joints: dict[str, Element]) -> list[str]:
    """Return the joints that move, from the base to the first link from which two ways move on."""
    ways: dict[str, list[str]] = {}
    for name, joint in reversed(joints.items()):
        parent, child = joint_ends(joint)
        if joint.get("type") != FIXED or child in ways:
            ways.setdefault(parent, []).append(name)
    children = {joint_ends(joint)[1] for joint in joints.values()}
    link = next((one for one in ways if one not in children), "")
    found: list[str] = []
    while len(ways.get(link, ())) == 1:
        (name,) = ways.pop(link)
        if joints[name].get("type") != FIXED:
            found.append(name)
        link = joint_ends(joints[name])[1]
    return found


def file_names(path: Path) -> tuple[str, ...]:
    """Return the joints of a file of limits, in its order.

    Raises:
        UserError: it is no such file.
    """
    return tuple(_read(path))


def allowed(
    joints: Sequence[str],
    urdf: Path | None = None,
    file: Path | None = None,
    speed: float = SPEED,
    until_fast: float = UNTIL_FAST,
) -> Limits:
    """Return the limits of a URDF, of a file, or those within both, a margin inside.

    Args:
        joints: N names.
        urdf: description of the robot.
        file: YAML such as MoveIt's: joint_limits, by joint min_position, max_position, max_velocity
            and, if wanted, max_acceleration, max_jerk, max_effort.
        speed: share of the highest speeds, 0 to 1.
        until_fast: s in which a joint may reach that speed.

    Raises:
        UserError: a file is of another form, or a limit is missing; names the joint.
    """
    if not 0.0 < speed <= 1.0:
        raise UserError(
            f"a speed of {speed:g}: expected a share of the limit, above 0 and at most 1"
        )
    if not until_fast > 0.0:
        raise UserError(f"{until_fast:g} s until a joint is fast: expected more than 0")
    endless = np.full(len(joints), np.inf)
    found = Limits(-endless, endless, endless, endless)
    if file is not None:
        found = _of_file(file, joints)
    if urdf is not None:
        found = urdf_limits(urdf, joints, found)
        turns = [urdf_joints(urdf)[name].get("type") == "continuous" for name in joints]
        round_ = np.where(turns, np.pi, np.inf)
        found = replace(
            found, q_low=np.maximum(found.q_low, -round_), q_high=np.minimum(found.q_high, round_)
        )
    return careful(found, joints, speed, until_fast)


def careful(
    limits: Limits, joints: Sequence[str], speed: float = SPEED, until_fast: float = UNTIL_FAST
) -> Limits:
    """Return a share of an arm's limits, a margin inside.

    Raises:
        UserError: one is missing or leaves no room; names the joint.
    """
    for n, name in enumerate(joints):
        ends = limits.q_low[n], limits.q_high[n], limits.qd_max[n]
        if not np.isfinite(ends).all():
            raise UserError(
                f"{name}: its range and speed are not known; give them in a file of limits "
                "(min_position, max_position, max_velocity)"
            )
    fastest = speed * limits.qd_max
    most = None if limits.tau_max is None else TORQUE * limits.tau_max
    if most is not None and not np.isfinite(most).all():
        most = None
    hardest = np.minimum(limits.qdd_max, fastest / until_fast)
    return Limits.within(
        replace(limits, qd_max=fastest, qdd_max=hardest, tau_max=most), tuple(joints)
    )


def _of_file(path: Path, joints: Sequence[str]) -> Limits:
    given = _read(path)
    if lacking := [name for name in joints if name not in given]:
        raise UserError(f"{path}: holds no limits of {', '.join(lacking)}; of {', '.join(given)}")
    columns: dict[str, Floats | None] = {}
    for field, key in FIELDS.items():
        values = [given[name].get(key) for name in joints]
        if field not in OPTIONAL and None in values:
            raise UserError(f"{path}: {joints[values.index(None)]} has no {key}")
        try:
            columns[field] = np.array([np.inf if one is None else float(one) for one in values])
        except (TypeError, ValueError) as error:
            raise UserError(f"{path}: {key}: expected numbers ({error})") from error
    if not np.isfinite(np.asarray(columns["jerk_max"])).all():
        columns["jerk_max"] = None
    return Limits(**columns)  # type: ignore[arg-type]


def _read(path: Path) -> Mapping[str, Mapping[str, Any]]:
    try:
        tree = yaml.safe_load(budget.text_of(path, UserError))
        found = {str(name): dict(one) for name, one in tree["joint_limits"].items()}
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from error
    except (yaml.YAMLError, UnicodeDecodeError, KeyError, TypeError, ValueError, AttributeError):
        raise UserError(
            f"{path}: expected joint_limits: JOINT: min_position, max_position, max_velocity: ..."
        ) from None
    if not found:
        raise UserError(f"{path}: joint_limits is empty")
    return found
