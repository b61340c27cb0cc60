"""The demo from its options to its results."""

import resource
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from rich.console import Console

from lagrangian_ff.demo.folder import Folder
from lagrangian_ff.demo.options import Options
from lagrangian_ff.demo.stages import Stages
from lagrangian_ff.errors import UserError

WIDTH = 100  # of the output without a terminal


def run(options: Options | None = None) -> int:
    """Record, identify and drive the simulated arm over ROS 2; show the results.

    Returns:
        0 once it is complete, whatever the figures; they are printed, in `demo.json` and on the
        page.

    Raises:
        UserError: ROS is missing, the folder cannot be written, or a node failed.
    """
    options = options or Options()
    try:
        # First of all: the wheels of ROS restart Python once, to set their library path.
        import rclpy  # noqa: F401
    except ImportError as error:
        raise UserError(
            f"the demo needs ROS 2 ({error}): source ROS 2 Jazzy, or install the extra: "
            "pip install -e '.[ros]' in the source folder"
        ) from error
    from lagrangian_ff.demo.conductor import own_graph
    from lagrangian_ff.demo.findings import print_findings
    from lagrangian_ff.demo.page import write_results
    from lagrangian_ff.demo.scenario import Scenario, motions_of

    console = Console(file=sys.stdout)
    if not console.is_terminal:
        console.width = WIDTH
    stages = Stages(console)
    folder = Folder(options.output)
    folder.prepare()
    console.print("[bold]From joint states to feedforward torque[/], over ROS 2", highlight=False)
    with _terminated_as_interrupted():
        with stages.stage("motions", "two motions through the workspace are planned"):
            motions = motions_of(options)
        scenario = Scenario(options, motions, folder, stages)
        with own_graph(options.domain) as (context, domain):
            hint = f"watch it from another shell: ROS_DOMAIN_ID={domain} ros2 topic list"
            console.print(f"  [dim]{hint}[/]", highlight=False)
            findings = scenario.play(context, domain)
        _add_own_memory(findings.memory)
        with stages.stage("page", "the figures and the page are drawn"):
            findings.seconds = stages.seconds
            write_results(findings, folder)
    print_findings(findings, folder, console)
    return 0


def _add_own_memory(memory: dict[str, int]) -> None:
    """Add the most memory, bytes, of the conductor and of the largest process below the nodes."""
    kilobyte = 1024
    memory["conductor"] = kilobyte * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    # The identification is a child of the identify node, which has waited for it by now.
    memory["largest child"] = kilobyte * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss


@contextmanager
def _terminated_as_interrupted() -> Iterator[None]:
    """Let SIGTERM unwind the demo as Ctrl-C does, so that no node is left."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
