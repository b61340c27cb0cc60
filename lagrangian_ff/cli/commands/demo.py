"""`demo`: the whole job over ROS 2, from recording to better tracking."""

from argparse import SUPPRESS, ArgumentParser, Namespace
from dataclasses import fields
from pathlib import Path

from lagrangian_ff.cli.common.claims import claim
from lagrangian_ff.cli.common.options import add_rows

NAME = "demo"
SUMMARY = "record, identify and drive the simulated arm over ROS 2"
USAGE = "[--output FOLDER] [options]"
DESCRIPTION = """\
Shows the whole job on real ROS 2: three processes record the simulated arm, identify it from
inputs and outputs alone, and track better with the learned feedforward torque, on the motion they
learned from and on one they have never seen."""
EPILOG = """\
examples:
  lagrangian_ff demo --output out
  lagrangian_ff demo --quick                  shorter motions, only to see everything work

what comes out:
  the torque error of each joint, and the tracking errors without feedforward, without its
  friction part, and with all of it, beside those with the plant's true torques, which are the
  bound; pictures and a page that shows them in the output folder.

Needs rclpy: source ROS 2 Jazzy, or pip install -e '.[ros]' in the source folder."""


def add_arguments(parser: ArgumentParser) -> None:
    # Defaults stand in the demo's Options alone: what is not given is absent.
    add_rows(parser, (
        ("--output", Path, "FOLDER",
         "the folder to write to, made if it is missing (default: out)"),
        ("--quick", bool, "", "shorter motions and fewer samples; a worse model"),
        ("--speed", int, "1..10", "speed of both motions (default: 5)"),
        ("--seed", int, "N", "seed of the motion that is learned from (default: 0)"),
        ("--duration", float, "SECONDS",
         "length of the motion that is learned from (default: 24)"),
        ("--unseen-duration", float, "SECONDS", "length of the motion never seen (default: 16)"),
        ("--model", str, "NAME", "kernel and effects, as for identify (default: auto+fri)"),
        ("--samples", int, "M", "training samples the model is built on (default: 1000)"),
        ("--train", float, "FRACTION", "share of the recording that is learned from (default: 1)"),
        ("--through", str, "stream|trajectory",
         "how the torque reaches the arm: one by one while it moves, or with the points of the "
         "trajectory before (default: stream)"),
        ("--clock-speed", float, "FACTOR",
         "speed of the arm's clock over real time, if the machine can keep up (default: 2)"),
        ("--domain", int, "N", "ROS domain to use (default: one that nobody uses)"),
    ), default=SUPPRESS)  # fmt: skip


def run(arguments: Namespace) -> int:
    from lagrangian_ff import demo
    from lagrangian_ff.demo.options import QUICK

    known = {field.name for field in fields(demo.Options)}
    given = {name: value for name, value in vars(arguments).items() if name in known}
    quick = QUICK if arguments.quick else {}
    options = demo.Options(**{**quick, **given})
    claim(options.output, "--output")
    return demo.run(options)
