"""Effects by name, and --effects-file for those that users bring."""

import warnings
from argparse import ArgumentParser, Namespace
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.errors import UserError

if TYPE_CHECKING:
    from lagrangian_ff.effects import Effect


def add_effects_file(parser: ArgumentParser) -> None:
    """--effects-file."""
    parser.add_argument(
        "--effects-file",
        type=Path,
        action="append",
        default=[],
        metavar="FILE.py",
        help="Python that defines effects of your own (see lagrangian_ff effects --help); may be "
        "given several times",
    )


def load_own_effects(arguments: Namespace, console: Console) -> None:
    """Let the effects of installed packages and of these files join the catalogue.

    Raises:
        EffectError: a file does not import, or an effect is not sound; names both.
    """
    from lagrangian_ff.effects import load_effects, load_installed

    _require_kept(arguments)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        load_installed()
    for warning in caught:
        console.note(str(warning.message), "")
    for path in arguments.effects_file:
        load_effects(path)


def _require_kept(arguments: Namespace) -> None:
    """Refuse to write over the file of effects."""
    for option in ("output", "json", "report", "picture"):
        written = getattr(arguments, option, None)
        for path in arguments.effects_file:
            if written is not None and Path(written).resolve() == path.resolve():
                raise UserError(
                    f"--{option} {written}: this command reads effects from that file; name another"
                )


def effect_named(name: str) -> "Effect":
    """The effect of a name.

    Raises:
        UserError: there is none; tells those with names like it.
    """
    from lagrangian_ff.effects import EFFECTS, GROUPS

    if name in EFFECTS:
        return EFFECTS[name]
    if name in GROUPS:
        raise UserError(f"'{name}' stands for {' and '.join(GROUPS[name])}: name one of them")
    near = get_close_matches(name, EFFECTS, 3)
    hint = f"did you mean {' or '.join(near)}? " if near else ""
    raise UserError(f"there is no effect '{name}': {hint}lagrangian_ff effects lists all")
