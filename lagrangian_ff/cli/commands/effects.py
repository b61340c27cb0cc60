"""`effects`: the catalogue of physical effects, or one of them explained."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.options import add_common, add_rows, effect_named, load_own_effects
from lagrangian_ff.cli.common.outputs import check_outputs, whole, write_record
from lagrangian_ff.cli.text.effects import say_catalogue, say_effect
from lagrangian_ff.errors import UserError

NAME = "effects"
SUMMARY = "list the physical effects that are known, or explain one"
USAGE = "[EFFECT] [options]"
DESCRIPTION = """\
Lists the physical effects that a model can have and a diagnosis looks for; or explains one: its
formula and source, its parameters with units, how it shows, what it is taken for and how the two
differ, and the motion that shows it."""
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
    parser.add_argument("effect", nargs="?", metavar="EFFECT", help="the name of one effect")
    add_rows(parser, [("--picture", Path, "FILE.png", "draw the torque of the effect")])
    add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    if arguments.picture is not None and arguments.effect is None:
        raise UserError(
            "--picture draws one effect: name it, as in lagrangian_ff effects stribeck --picture "
            f"{arguments.picture}"
        )
    check_outputs(arguments, [])
    load_own_effects(arguments, console)
    from lagrangian_ff.effects import EFFECTS, effect_record

    if arguments.effect is None:
        say_catalogue(EFFECTS.values(), console)
        console.say("lagrangian_ff effects EFFECT explains one of them")
        write_record(arguments.json, {"effects": list(map(effect_record, EFFECTS.values()))})
        return 0
    effect = effect_named(arguments.effect)
    say_effect(effect, console)
    write_record(arguments.json, effect_record(effect))
    if arguments.picture is not None:
        from lagrangian_ff.report.effect_picture import signature_figure
        from lagrangian_ff.report.style import png

        picture = png(signature_figure(effect))
        with whole(arguments.picture) as path:
            path.write_bytes(picture)
        console.say(["", f"saved: {arguments.picture}"])
    return 0
