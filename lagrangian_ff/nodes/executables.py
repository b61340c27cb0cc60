"""The executables of the nodes. They end quietly also while the libraries are still loading."""

import importlib
import os
import signal
import sys

from lagrangian_ff.errors import UserError


def _run(name: str) -> int:
    """Import a node and run it; until it has its own handlers, a signal ends the process."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: os._exit(0))
    try:
        node = importlib.import_module(f"lagrangian_ff.nodes.{name}")
    except UserError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return int(node.main())


def arm() -> int:
    """Run the simulated arm."""
    return _run("arm")


def feedforward() -> int:
    """Run the feedforward."""
    return _run("feedforward")


def identify() -> int:
    """Run the recorder that identifies."""
    return _run("identify")


def monitor() -> int:
    """Run the monitor."""
    return _run("monitor")


def watchdog() -> int:
    """Run the watchdog."""
    return _run("watchdog")
