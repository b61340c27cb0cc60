"""--hidden EFFECT@JOINT:SIZE: physics that the simulated arm's description does not mention."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from lagrangian_ff.cli.common.progress import progress_bar
from lagrangian_ff.errors import UserError

if TYPE_CHECKING:
    from lagrangian_ff.arm.hidden import HiddenEffect, Installed, Site

SPEED, SEED, SECONDS = 5, 0, 20.0
"""Of the motion along which effects are sized, so that every recording is of the same arm."""
CLOSE = 0.05
"""Of the size: what is this near to it is said to have it."""


@dataclass(frozen=True)
class Wanted:
    """An effect to hide, on a joint (0 to 5), of a size: its torque's rms over the joint's."""

    effect: "HiddenEffect"
    joint: int
    size: float


@dataclass(frozen=True)
class Hidden:
    """What is put into the arm; `arm` is what `lagrangian_ff.arm.simulate` takes.

    Attributes:
        records: for JSON, one an effect.
    """

    arm: dict[str, Any] = field(default_factory=dict)
    records: tuple[dict[str, Any], ...] = ()


def wanted(texts: Sequence[str]) -> list[Wanted]:
    """What --hidden asks for.

    Raises:
        UserError: it is of another form, there is no such effect or joint, or it cannot be there.
    """
    if not texts:
        return []
    from lagrangian_ff.arm import JOINTS
    from lagrangian_ff.arm.hidden import HIDDEN

    asked = []
    for text in texts:
        place, colon, number = text.partition(":")
        name, at, joint = place.partition("@")
        try:
            size = float(number)
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
        if not 0.0 < size <= 1.0:
            raise UserError(
                f"--hidden {text}: the size is the effect's torque over that of the joint, above 0 "
                "and at most 1"
            )
        asked.append(Wanted(HIDDEN[name], JOINTS.index(joint), size))
    return asked


def hidden(asked: Sequence[Wanted], recording: int) -> Hidden:
    """Build what is asked for.

    Args:
        asked: see `wanted`.
        recording: the number of the recording; what happens by chance in time follows it.

    Raises:
        UserError: two effects need a load at the tool, of which there can be one.
    """
    if not asked:
        return Hidden()
    from lagrangian_ff.arm import exciting_trajectory, simulate
    from lagrangian_ff.arm.hidden import Reference, Site, sized

    with progress_bar("sizing what is hidden") as progress:
        run = simulate(exciting_trajectory(SPEED, SEED, SECONDS), progress=progress)
    along = Reference.of(run)
    parts, records = [], []
    for number, one in enumerate(asked):
        site = Site(one.joint, number, recording, along)
        part, _ = sized(one.effect, site, one.size)
        parts.append(part)
        records.append(_record(one, part, site))
    attached = [part.attached for part in parts if part.attached is not None]
    if len(attached) > 1:
        raise UserError("--hidden: the arm can take up one load only; name one payload")
    return Hidden(
        {
            "effects": [effect for part in parts for effect in part.effects],
            "sensors": [sensor for part in parts for sensor in part.sensors],
            "gears": [gear for part in parts for gear in part.gears],
            "attached": attached[0] if attached else None,
        },
        tuple(records),
    )


def _record(one: Wanted, part: "Installed", site: "Site") -> dict[str, Any]:
    from lagrangian_ff.arm import JOINTS
    from lagrangian_ff.arm.hidden import size

    return {
        "effect": one.effect.name,
        "joint": JOINTS[one.joint],
        "size": size(one.effect, part, site),
        "wanted": one.size,
        "physics": one.effect.physics,
        "facts": dict(part.facts),
    }


def told(record: dict[str, Any]) -> str:
    """A hidden effect in words."""
    text = (
        f"hidden in the arm: {record['physics']} ({record['effect']} on {record['joint']}), "
        f"{record['size']:.1%} of the joint's torque"
    )
    if record["size"] < (1.0 - CLOSE) * record["wanted"]:
        text += ", as much as this physics can make"
    return text
