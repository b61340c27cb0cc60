"""Options that several commands have, and the forms that their values take."""

import warnings
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Callable, Iterable, Sequence
from difflib import get_close_matches
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.errors import UserError

if TYPE_CHECKING:
    from argparse import _ActionsContainer

    from lagrangian_ff.arrays import Floats
    from lagrangian_ff.effects import Effect
    from lagrangian_ff.recording import Conditioning

SOURCE_HELP = (
    "a recording: a rosbag2 folder, a .db3 or .mcap file, a .csv with the header "
    "time,position/<joint>,velocity/<joint>,effort/<joint> (velocity optional), or an .npz with "
    "time, position, velocity, effort, joints; temperature/<joint>, temperature in an .npz, and "
    "topics of sensor_msgs/Temperature that name a joint are read too"
)


Row = tuple[str, Callable[[str], object] | tuple[str, ...], str, str]
"""An option: its flag, kind, the name of its value and its help."""


def add_rows(where: "_ActionsContainer", rows: Iterable[Row], **how: Any) -> None:
    """Declare options.

    Args:
        where: parser or group.
        rows: the kind is the type of the value, its choices, bool for a switch without one, or
            list for several values, given at once or in turn; a flag with a type may have other
            names behind it.
        how: further arguments of `add_argument`, for all that have one value.
    """
    for flag, kind, metavar, text in rows:
        if kind is list:
            add_list(where, flag, metavar, text)
        elif kind is bool:
            where.add_argument(flag, action="store_true", help=text)
        elif isinstance(kind, tuple):
            where.add_argument(flag, choices=kind, help=text, **how)
        else:
            where.add_argument(*flag.split(), type=kind, metavar=metavar or None, help=text, **how)


def add_list(
    where: "_ActionsContainer", option: str, metavar: str, help_: str, kind: type = str
) -> None:
    """Declare an option that takes several values and may be given several times."""
    where.add_argument(
        option, type=kind, nargs="+", action="extend", default=[], metavar=metavar, help=help_
    )


def add_model(parser: ArgumentParser, help_: str = "a model file of identify") -> None:
    """Declare MODEL."""
    parser.add_argument("model", type=Path, metavar="MODEL", help=help_)


def add_sources(parser: ArgumentParser, together: str) -> None:
    """Declare SOURCE, several of which are `together`, as in "judged together"."""
    help_ = f"{SOURCE_HELP}; several are {together}"
    parser.add_argument("sources", type=Path, nargs="+", metavar="SOURCE", help=help_)


def add_report(parser: ArgumentParser) -> None:
    """Declare --report."""
    add_rows(parser, [("--report", Path, "FILE.html", "write a page with interactive figures")])


def add_reading(parser: ArgumentParser) -> None:
    """Declare --topic and the options of the chain from a recording to a motion."""
    add_topic(parser)
    add_conditioning(parser)


def add_conditioning(parser: ArgumentParser) -> None:
    """Declare the options of the chain from a recording to a motion."""
    add_rows(parser.add_argument_group("how the recording is made ready"), (
        ("--effort-scale", list, "JOINT=VALUE", "N·m per unit of effort, if the driver reports "
         "current or the other sign; 1 for joints not named"),
        ("--effort-offset", list, "JOINT=VALUE",
         "N·m added to the torque after scaling; 0 for joints not named"),
        ("--effort-delay", float, "S",
         "s by which the effort comes later than the position, as diagnose finds it"),
        ("--effort", ("total", "without-gravity", "without-friction"), "",
         "what the recorded effort holds: all torque of the joint; torque from which the driver "
         "removed gravity, as those of UR and Franka can report; or torque without the friction "
         "that the drive compensates. Model and feedforward then hold the same (default: total; "
         "with a model what its recordings held)"),
        ("--units", list, "QUANTITY=UNIT",
         "what was recorded, if not s, rad, rad/s and N·m: time=ms, us or ns; position=deg or "
         "mrad; velocity=deg/s, rpm or mrad/s; effort=mNm, Ncm, kNm, kgfcm, kgfm, lbfin or lbfft"),
        ("--bandwidth", _bandwidth, "HZ|auto", "cut-off of the low-pass on position and torque, "
         "one for all joints; auto: as wide as their noise allows, up to 25 Hz and a quarter of "
         "the rate (default: that of the model if there is one, else auto)"),
        ("--rate", float, "HZ",
         "sample rate of the motion that is made (default: that of the recording)"),
        ("--clock", ("auto", "stamps", "steady"), "", "stamps: believe the stamps; steady: samples "
         "were taken by a steady clock and stamped late; auto: whichever the motion follows "
         "(default: auto)"),
    ))  # fmt: skip


def _bandwidth(text: str) -> float | str:
    """Return what --bandwidth gives."""
    if text == "auto":
        return text
    try:
        return float(text)
    except ValueError:
        raise ArgumentTypeError(f"{text!r}: expected a number in Hz, or auto") from None


def add_topic(parser: ArgumentParser) -> None:
    """Declare --topic."""
    add_rows(parser, [("--topic", str, "T", "the JointState topic of a bag that holds several")])


def add_common(parser: ArgumentParser, *, effects: bool = True) -> None:
    """Declare --effects-file, unless effects play no part, --json and --force."""
    if effects:
        text = (
            "a Python file that defines your own effects (see lagrangian_ff effects --help); may "
            "be given several times"
        )
        row = ("--effects-file", Path, "FILE.py", text)
        add_rows(parser, [row], action="append", default=[])
    add_rows(parser, (
        ("--json", str, "FILE", "write the findings as JSON; - for standard output (the text then "
         "goes to standard error)"),
        ("--force", bool, "", "replace output files that exist already"),
    ))  # fmt: skip


def names(texts: Sequence[str]) -> tuple[str, ...]:
    """Return names that were given one by one or joined by commas."""
    return tuple(name.strip() for text in texts for name in text.split(",") if name.strip())


def assignments(option: str, texts: Sequence[str]) -> dict[str, float]:
    """Return numbers by joint, given as joint=value, one by one or joined by commas.

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


def gears(texts: Sequence[str], joints: Sequence[str]) -> dict[str, str]:
    """Return the kind of gear by joint, given as one for all or as joint=gear.

    Raises:
        UserError: there is no such joint or gear.
    """
    from lagrangian_ff.effects.usual import gear

    found: dict[str, str] = {}
    for part in names(texts):
        joint, sign, kind = part.rpartition("=")
        gear(kind)
        if sign and joint not in joints:
            raise UserError(
                f"--gear {part}: there is no joint {joint}; there are {', '.join(joints)}"
            )
        found |= dict.fromkeys([joint] if sign else joints, kind)
    return found


def pose(option: str, texts: Sequence[str], joints: Sequence[str], usual: "Floats") -> "Floats":
    """Return (N,) the usual values of the joints with those that the user gives.

    Raises:
        UserError: a value is of another form, or of a joint that is not there.
    """
    given = assignments(option, texts)
    unknown = [name for name in given if name not in joints]
    if unknown:
        raise UserError(f"{option}: no joint {', '.join(unknown)}; there are {', '.join(joints)}")
    out = usual.copy()
    for name, value in given.items():
        out[list(joints).index(name)] = value
    return out


def check_seed(arguments: Namespace) -> None:
    """Raise UserError if --seed is negative."""
    if arguments.seed < 0:
        raise UserError(f"--seed {arguments.seed}: expected a whole number from 0 up")


def conditioning_of(arguments: Namespace, before: "Conditioning | None" = None) -> "Conditioning":
    """Return how recordings are made ready, from the options of `add_reading`.

    What is not given stays as it was `before`; None takes the defaults.

    Raises:
        UserError: a value is of another form, or not possible.
    """
    from dataclasses import replace

    from lagrangian_ff.recording import Conditioning
    from lagrangian_ff.recording.units import named_units

    given: dict[str, object] = {}
    for option in ("effort_scale", "effort_offset"):
        values = assignments(f"--{option.replace('_', '-')}", getattr(arguments, option))
        if values:
            given[option] = {**(getattr(before, option) if before else {}), **values}
    if arguments.units:
        units = named_units(names(arguments.units))
        given["units"] = {**(before.units if before else {}), **units}
    for option in ("bandwidth", "rate", "clock", "effort", "effort_delay"):
        if getattr(arguments, option) is not None:
            given[option] = getattr(arguments, option)
    if given.get("bandwidth") == "auto":
        given["bandwidth"] = None
    return replace(before or Conditioning(), **given)  # type: ignore[arg-type]


def load_own_effects(arguments: Namespace, console: Console) -> None:
    """Add the effects of installed packages and of --effects-file to the catalogue.

    Raises:
        EffectError: a file does not import, or an effect is not sound; names both.
        UserError: an output would replace a file of effects.
    """
    from lagrangian_ff.effects import load_effects, load_installed

    for option in ("output", "json", "report", "picture"):
        written = getattr(arguments, option, None)
        for path in arguments.effects_file:
            if written is not None and Path(written).resolve() == path.resolve():
                raise UserError(
                    f"--{option} {written}: this command reads effects from that file; name another"
                )
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        load_installed()
    for warning in caught:
        console.note(str(warning.message))
    for path in arguments.effects_file:
        load_effects(path)
    console.option = " ".join(f"--effects-file {quote(str(one))}" for one in arguments.effects_file)


def effect_named(name: str) -> "Effect":
    """Return the effect of a name.

    Raises:
        UserError: there is none; names those whose names are near.
    """
    from lagrangian_ff.effects import EFFECTS, GROUPS

    if name in EFFECTS:
        return EFFECTS[name]
    if name in GROUPS:
        raise UserError(f"'{name}' stands for {' and '.join(GROUPS[name])}: name one of them")
    near = get_close_matches(name, EFFECTS, 3)
    hint = f"did you mean {' or '.join(near)}? " if near else ""
    raise UserError(f"there is no effect '{name}': {hint}lagrangian_ff effects lists all")
