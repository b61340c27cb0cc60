"""`effects`: which physical effects there are, and what each looks like."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.options import add_force, add_json
from lagrangian_ff.cli.common.outputs import check_file, whole, write_record
from lagrangian_ff.cli.common.own_effects import add_effects_file, effect_named, load_own_effects
from lagrangian_ff.cli.text.effect_page import say_catalogue, say_effect
from lagrangian_ff.errors import UserError

if TYPE_CHECKING:
    from lagrangian_ff.effects import Effect

NAME = "effects"
SUMMARY = "list the physical effects that are known, or explain one"
USAGE = "[EFFECT] [options]"
DESCRIPTION = """\
Lists the physical effects that a model can have and a diagnosis looks for; or explains one: its
formula and source, its parameters with units, how it shows, what it is taken for and how the two
are told apart, and the motion that shows it."""
EPILOG = """\
examples:
  lagrangian_ff effects
  lagrangian_ff effects stribeck --picture stribeck.png
  lagrangian_ff effects --effects-file my_effects.py

an effect of your own is a Python file of ten lines:
  import numpy as np
  from lagrangian_ff.effects import Effect, Parameter

  class Pit(Effect):
      name = "pit"
      formula = "F sign(qd) exp(-((q - 0.4) / 0.1)^2)"
      parameters = (Parameter("F", "N·m", "extra friction in a worn place"),)

      def columns(self, x, joint, shape):
          return (x.sign(joint) * np.exp(-(((x.q[:, joint] - 0.4) / 0.1) ** 2)))[:, None]"""


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("effect", nargs="?", metavar="EFFECT", help="the name of one effect")
    parser.add_argument(
        "--picture", type=Path, metavar="FILE.png", help="draw the torque of the effect"
    )
    add_effects_file(parser)
    add_json(parser)
    add_force(parser)


def run(arguments: Namespace) -> int:
    """See `Command`."""
    console = Console(arguments.json)
    _check_outputs(arguments)
    load_own_effects(arguments, console)
    from lagrangian_ff.effects import EFFECTS

    if arguments.effect is None:
        records = [effect.record() for effect in EFFECTS.values()]
        say_catalogue(records, console)
        console.say("lagrangian_ff effects EFFECT explains one of them")
        write_record(arguments.json, {"effects": records})
        return 0
    effect = effect_named(arguments.effect)
    say_effect(effect.record(), type(effect).__doc__ or "", console)
    write_record(arguments.json, effect.record())
    if arguments.picture is not None:
        _draw(effect, arguments.picture)
        console.say(["", f"saved: {arguments.picture}"])
    return 0


def _check_outputs(arguments: Namespace) -> None:
    kept: list[Path] = []
    if arguments.picture is not None:
        if arguments.effect is None:
            raise UserError("--picture draws one effect: name it, as in lagrangian_ff effects "
                            f"stribeck --picture {arguments.picture}")  # fmt: skip
        check_file(arguments.picture, "--picture", force=arguments.force, suffix=".png", keep=kept)
        kept.append(arguments.picture)
    if arguments.json not in (None, "-"):
        check_file(Path(arguments.json), "--json", force=arguments.force, keep=kept)


def _draw(effect: "Effect", path: Path) -> None:
    from lagrangian_ff.report.figures.signature import signature_figure
    from lagrangian_ff.report.style import png

    picture = png(signature_figure(effect))
    with whole(path) as made:
        made.write_bytes(picture)
