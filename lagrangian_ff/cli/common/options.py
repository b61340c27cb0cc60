"""Options that several commands have, and the forms their values take."""

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from typing import TYPE_CHECKING

from lagrangian_ff.errors import UserError

if TYPE_CHECKING:
    from lagrangian_ff.recording import Conditioning

SOURCE_HELP = (
    "a recording: a rosbag2 folder, a .db3 or .mcap file, a .csv with the header "
    "time,position/<joint>,velocity/<joint>,effort/<joint> (velocity optional), or an .npz with "
    "time, position, velocity, effort, joints"
)


def add_topic(parser: ArgumentParser) -> None:
    """--topic."""
    parser.add_argument(
        "--topic", metavar="T", help="the JointState topic of a bag that holds several"
    )


def add_conditioning(parser: ArgumentParser) -> None:
    """The options of the chain from a recording to a motion."""
    group = parser.add_argument_group("how the recording is made ready")
    group.add_argument(
        "--effort-scale",
        nargs="+",
        action="extend",
        default=[],
        metavar="JOINT=VALUE",
        help="N·m per unit of effort, where the driver reports current or the other sign; "
        "1 for joints not named",
    )
    group.add_argument(
        "--effort-offset",
        nargs="+",
        action="extend",
        default=[],
        metavar="JOINT=VALUE",
        help="N·m added to the torque after scaling; 0 for joints not named",
    )
    group.add_argument(
        "--bandwidth",
        type=float,
        metavar="HZ",
        help="of the low-pass on position and torque (default: 25; reduced for slow recordings)",
    )
    group.add_argument(
        "--rate",
        type=float,
        metavar="HZ",
        help="of the motion that is made (default: that of the recording)",
    )
    group.add_argument(
        "--clock",
        choices=("auto", "stamps", "steady"),
        help="stamps: believe the stamps; steady: samples were taken by a steady clock and stamped "
        "late; auto: whichever the motion follows (default: auto)",
    )


def add_json(parser: ArgumentParser) -> None:
    """--json."""
    parser.add_argument(
        "--json",
        metavar="FILE",
        help="write the findings as JSON; - for standard output (the text then goes to standard "
        "error)",
    )


def add_force(parser: ArgumentParser) -> None:
    """--force."""
    parser.add_argument(
        "--force", action="store_true", help="replace output files that exist already"
    )


def names(texts: Sequence[str]) -> tuple[str, ...]:
    """Names given one by one or joined by commas."""
    return tuple(name.strip() for text in texts for name in text.split(",") if name.strip())


def assignments(option: str, texts: Sequence[str]) -> dict[str, float]:
    """Numbers by joint, given as joint=value, one by one or joined by commas.

    Raises:
        UserError: one is of another form, or a joint is named twice.
    """
    values: dict[str, float] = {}
    for part in names(texts):
        joint, sign, number = part.rpartition("=")
        try:
            value = float(number)
        except ValueError:
            sign = ""
        if not sign or not joint:
            raise UserError(f"{option} {part}: expected joint=number, as in {option} elbow=1.5")
        if joint in values:
            raise UserError(f"{option}: {joint} is given twice")
        values[joint] = value
    return values


def check_seed(arguments: Namespace) -> None:
    """Refuse a --seed that is none.

    Raises:
        UserError: it is negative.
    """
    if arguments.seed < 0:
        raise UserError(f"--seed {arguments.seed}: expected a whole number from 0 up")


def conditioning_of(arguments: Namespace, before: "Conditioning | None" = None) -> "Conditioning":
    """How recordings are made ready, from the options.

    Args:
        arguments: with the options of `add_conditioning`.
        before: what holds where an option is not given; None for the usual.

    Raises:
        UserError: a value of another form, or not possible.
    """
    from dataclasses import replace

    from lagrangian_ff.recording import Conditioning

    given: dict[str, object] = {}
    for option in ("effort_scale", "effort_offset"):
        values = assignments(f"--{option.replace('_', '-')}", getattr(arguments, option))
        if values:
            given[option] = {**(getattr(before, option) if before else {}), **values}
    for option in ("bandwidth", "rate", "clock"):
        if getattr(arguments, option) is not None:
            given[option] = getattr(arguments, option)
    return replace(before or Conditioning(), **given)  # type: ignore[arg-type]
