"""`workbench`: the whole loop with the mouse, on a page."""

import asyncio
import re
import webbrowser
from argparse import ArgumentParser, Namespace
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.outputs import check_sources
from lagrangian_ff.errors import UserError

if TYPE_CHECKING:
    from collections.abc import Callable

    from lagrangian_ff.workbench.handler import Part, Service
    from lagrangian_ff.workbench.investigating import Arm

NAME = "workbench"
SUMMARY = "open a page on which a model is learned, looked at and mended"
USAGE = "[SOURCE ...] [options]"
DESCRIPTION = """\
Opens a page: drop a recording, learn a model, see where it fails and what is missing, add it, watch
the error fall, take the model away. The page is on this machine alone, and needs no network."""
EPILOG = """\
examples:
  lagrangian_ff workbench
  lagrangian_ff workbench monday_bag tuesday_bag --session monday
  lagrangian_ff workbench --try            a simulated arm with something hidden in it
  lagrangian_ff workbench --live           beside a robot that publishes joint_states

what stays:
  the session is a folder, written at every change. Ctrl-C ends the server; the same command with
  the same --session goes on where it ended."""


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("sources", type=Path, nargs="*", metavar="SOURCE", help="recordings")
    options.add_rows(parser, (
        ("--session", Path, "FOLDER", "folder of the session (default: workbench_session)"),
        ("--try", bool, "", "begin with recordings of a simulated arm that hides an effect"),
        ("--seed", int, "N", "with --try: which effect is hidden (default: 0)"),
        ("--urdf", Path, "FILE", "description of the robot, to draw the arm at the cursor, "
         "and whose bodies a model can be learned with"),
        ("--live", bool, "", "attach to a ROS graph: stream residuals, record, send motions"),
        ("--topic", str, "NAME", "with --live: the joint states (default: joint_states)"),
        ("--namespace", str, "NAME", "with --live: of the robot's topics (default: none)"),
        ("--port", int, "N", "port of the page (default: 8765)"),
        ("--host", str, "ADDRESS", "address to listen on; others than 127.0.0.1 ask for a token "
         "(default: 127.0.0.1)"),
        ("--no-browser", bool, "", "open no browser"),
    ))  # fmt: skip


def run(arguments: Namespace) -> int:
    console = Console()
    if find_spec("tornado") is None:
        raise UserError(
            "the workbench needs Tornado: apt install python3-tornado, or pip install tornado"
        )
    check_sources(arguments.sources)
    joined, arm = _attached(arguments)
    from lagrangian_ff.workbench.server import serve
    from lagrangian_ff.workbench.session import Session
    from lagrangian_ff.workbench.skeleton import read_skeleton

    folder = (arguments.session or Path("workbench_session")).absolute()
    session = Session.open(folder)
    sources, urdf = list(arguments.sources), arguments.urdf
    if getattr(arguments, "try") and not session.cards:
        from lagrangian_ff.cli.common.trial import record

        sources += record(folder, arguments.seed or 0)
    if getattr(arguments, "try") and urdf is None:
        urdf = Path(str(files("lagrangian_ff"))) / "arm" / "arm6.urdf"
    skeleton = [] if urdf is None else read_skeleton(urdf)
    if arm is None and getattr(arguments, "try"):
        from lagrangian_ff.cli.common.arms import SimulatedArm
        from lagrangian_ff.cli.common.trial import hidden_by

        arm = SimulatedArm(hidden_by(arguments.seed or 0))
    session.urdf = "" if urdf is None else str(urdf.absolute())

    def said(address: str) -> None:
        console.say([f"workbench: {address}", f"session: {folder}", "Ctrl-C ends it"])
        if not arguments.no_browser:
            webbrowser.open(address)

    port = 8765 if arguments.port is None else arguments.port
    asyncio.run(
        serve(session, sources, port, arguments.host or "127.0.0.1", said, skeleton, joined, arm)
    )
    return 0


def _attached(arguments: Namespace) -> "tuple[list[Callable[[Service], Part]], Arm | None]":
    """Return what attaches the workbench to a ROS graph, and its arm; nothing without --live.

    Raises:
        UserError: an option that needs --live, or a name that is none.
    """
    if not arguments.live:
        for option in ("topic", "namespace"):
            if getattr(arguments, option) is not None:
                raise UserError(f"--{option} needs --live")
        return [], None
    from lagrangian_ff.cli.common.arms import RobotArm
    from lagrangian_ff.workbench.live_pages import attached

    given = ["--ros-args"]
    for option, name in (("topic", "joint_states"), ("namespace", "__ns")):
        value = getattr(arguments, option)
        if value is None:
            continue
        if not re.fullmatch(r"/?[A-Za-z]\w*(/[A-Za-z]\w*)*", value, re.ASCII):
            raise UserError(
                f"--{option} {value}: expected a name of ROS, such as /left/joint_states"
            )
        rooted = f"/{value.strip('/')}" if option == "namespace" else value
        given += ["-r", f"{name}:={rooted}"]
    return [attached(given)], RobotArm(tuple(given))
