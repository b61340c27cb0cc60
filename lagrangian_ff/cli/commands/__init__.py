"""The commands; a new one is one file here and its name in the list.

A command is a module with NAME, SUMMARY (one line in the list of commands), USAGE (its arguments in
short), DESCRIPTION (what it does), EPILOG (examples and what the output means), `add_arguments` and
`run`.
"""

from argparse import ArgumentParser, Namespace
from importlib import import_module
from typing import Protocol, cast


class Command(Protocol):
    """The content of a command's module."""

    NAME: str
    SUMMARY: str
    USAGE: str
    DESCRIPTION: str
    EPILOG: str

    def add_arguments(self, parser: ArgumentParser) -> None:
        """Declare the arguments."""

    def run(self, arguments: Namespace) -> int:
        """Do it, and return the exit code.

        Raises:
            UserError: a mistake that the user can mend.
        """


_FILES = (
    "identify", "compare", "diagnose", "add", "propose", "history", "excite", "investigate",
    "effects", "calibrate", "predict", "feedforward", "export", "simulate", "info", "layout",
    "workbench", "demo", "study",
)  # fmt: skip
"""The file of each command beside this one, in the order in which they are listed."""

COMMANDS = tuple(cast(Command, import_module(f"{__name__}.{file}")) for file in _FILES)
