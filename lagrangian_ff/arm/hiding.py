"""Hidden effects by what a user asks for: EFFECT@JOINT:SIZE."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from lagrangian_ff.arm.description import JOINTS
from lagrangian_ff.arm.exciting import exciting_trajectory
from lagrangian_ff.arm.hidden.base import HiddenEffect, Reference, Site, size, sized, together
from lagrangian_ff.arm.hidden.catalogue import HIDDEN
from lagrangian_ff.arm.simulation import simulate
from lagrangian_ff.errors import UserError
from lagrangian_ff.progress import Progress, silent

SIZED = 5, 0, 20.0
"""Speed, seed and s of the motion along which effects are sized, so that every recording is of the
same arm."""


@dataclass(frozen=True)
class Wanted:
    """An effect to hide, on a joint (0 to 5), of a size: its torque's rms over the joint's."""

    effect: HiddenEffect
    joint: int
    size: float


@dataclass(frozen=True)
class Hidden:
    """Hidden physics of the arm; `arm` is what `Arm` and `simulate` take.

    Attributes:
        records: for JSON, one for each effect.
    """

    arm: dict[str, Any] = field(default_factory=dict)
    records: tuple[dict[str, Any], ...] = ()


def wanted(texts: Sequence[str]) -> list[Wanted]:
    """Return the effects that texts such as stribeck@joint_3:0.1 ask for.

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
                f"hidden {text}: expected EFFECT@JOINT:SIZE, as in stribeck@joint_3:0.1"
            )
        if name not in HIDDEN:
            raise UserError(f"hidden {text}: no effect '{name}'; there are {', '.join(HIDDEN)}")
        possible = [JOINTS[n] for n in HIDDEN[name].joints]
        if joint not in possible:
            raise UserError(f"hidden {text}: {name} can be on {', '.join(possible)}")
        if not 0.0 < share <= 1.0:
            raise UserError(
                f"hidden {text}: the size is the effect's torque over that of the joint, above 0 "
                "and at most 1"
            )
        asked.append(Wanted(HIDDEN[name], JOINTS.index(joint), share))
    return asked


def usual_motion(progress: Progress = silent) -> Reference:
    """Return the motion along which effects are sized."""
    return Reference.of(simulate(exciting_trajectory(*SIZED), progress=progress))


def hidden(
    asked: Sequence[Wanted],
    recording: int,
    progress: Progress = silent,
    along: Reference | None = None,
) -> Hidden:
    """Size and build the hidden effects; those that depend on chance follow the recording's number.

    Args:
        along: the usual motion, if it was simulated before.

    Raises:
        UserError: two effects need a load at the tool, of which there can be one.
    """
    if not asked:
        return Hidden()
    along = along or usual_motion(progress)
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
        raise UserError("hidden: the arm can take up one load only; name one payload")
    return Hidden(together(parts), tuple(records))
