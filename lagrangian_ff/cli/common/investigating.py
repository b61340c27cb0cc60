"""An investigation on the terminal: questions to the user, Ctrl-C, progress, and what came out."""

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console, table
from lagrangian_ff.numbers import number
from lagrangian_ff.progress import Progress

if TYPE_CHECKING:
    from lagrangian_ff.investigation import Investigation, Proposal
    from lagrangian_ff.nodes.attached.rig import RosRig

WORD = "yes"
INTERRUPTED = 130
"""Exit code after Ctrl-C, as of every command."""


@dataclass
class Stopping:
    """The handling of Ctrl-C.

    Attributes:
        rig: to stop; None for an arm that cannot move by itself.
        asked: how often it was pressed.
    """

    rig: "RosRig | None" = None
    asked: int = 0

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Let the arm be stopped, or end what is computed; what is known is kept."""
        from lagrangian_ff.investigation import StoppedError

        self.asked += 1
        words = f"stopped by the user ({signal.Signals(number).name})"
        if self.rig is not None:
            self.rig.stop(words)
            if self.rig.moving:
                return  # it stops the arm, then raises
        if self.asked > 1:
            raise KeyboardInterrupt
        raise StoppedError(words)


@contextmanager
def interruptible() -> Iterator[Stopping]:
    """Let Ctrl-C and SIGTERM end an investigation, which keeps what is known."""
    stopping = Stopping()
    before = {number: signal.signal(number, stopping) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stopping
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def lines(console: Console) -> Progress:
    """Return progress that prints a line for every step."""
    last = ""

    def report(share: float, label: str) -> None:
        nonlocal last
        if label != last:
            last = label
            console.say(f"[{share:4.0%}] {label}")

    return report


def say_proposal(proposal: "Proposal", console: Console, arm: str) -> None:
    """Print what the arm is to be permitted."""
    limits = proposal.limits
    console.say(["", f"{arm}: to move for up to {proposal.seconds:.0f} s"])
    columns = proposal.start, limits.q_low, limits.q_high, limits.qd_max, limits.qdd_max
    rows = [
        [name, *(number(float(one[n])) for one in columns)]
        for n, name in enumerate(proposal.joints)
    ]
    header = ["joint", "from [rad]", "lowest", "highest", "top speed [rad/s]", "acceleration"]
    console.say(table(header, rows))


def ask() -> bool:
    """Return whether the user permits it, on the terminal."""
    print(f"may it move so? type {WORD}: ", end="", file=sys.stderr, flush=True)
    line = sys.stdin.readline()
    if not line:
        print("\nnobody answers: --yes TOPIC permits it without a terminal", file=sys.stderr)
    return line.strip().lower() == WORD


def say(found: "Investigation", console: Console) -> None:
    """Print what an investigation did and found."""
    console.say(["", f"ended after {found.seconds:.0f} s of motion: {found.words}"])
    for count, turn in enumerate(found.turns, 1):
        console.say(f"{count}. {turn.asked} ({turn.seconds:.0f} s)")
        console.paragraph(turn.answer, "   ", "   ")
    if not found.turns:
        console.say("nothing is known")
        return
    for text in found.left:
        console.paragraph(text, "   ", "   ")
    last = found.turns[-1]
    console.say(["", "error on motion that no model learned from, rms in N·m"])
    errors, total = (found.errors, found.total) if found.curves else (last.errors, last.total)
    rows = [[name, number(found.before[name]), number(errors[name])] for name in found.joints]
    rows.append(["all joints", number(found.before_total), number(total)])
    console.say(table(["joint", "before", "after"], rows))
    names = ", ".join(one.name for one in found.confirmed)
    console.say(f"confirmed and added: {names or 'nothing'}")
    for one in found.curves:
        words = (
            f"taken in as a curve: {one.joint} over {one.coordinate}, which no known effect fits"
        )
        console.say(words)
    added = [one.name for one in found.formulas]
    for proposals in found.unlisted.proposals if found.unlisted else ():
        for formula in proposals.proposals:
            verdict = "added" if formula.finding.name in added else formula.finding.said
            said = f"formula for {proposals.joint}, {verdict}: {formula.formula}"
            console.say(said)
            console.paragraph(formula.words, "  ", "  ")
