"""The commands, listed once; a new one is one file here.

A command is a module with NAME, SUMMARY (one line in the list of commands), USAGE (its arguments in
short), DESCRIPTION (what it does), EPILOG (examples and what the output means), `add_arguments` and
`run`.
"""

from argparse import ArgumentParser, Namespace
from typing import Protocol

from lagrangian_ff.cli.commands import (
    add,
    compare,
    demo,
    diagnose,
    effects,
    excite,
    feedforward,
    history,
    identify,
    info,
    predict,
    simulate,
    study,
)


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


COMMANDS: tuple[Command, ...] = (
    identify, compare, diagnose, add, history, excite, effects, predict, feedforward, simulate,
    info, demo, study,
)  # fmt: skip
