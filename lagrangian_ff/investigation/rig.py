"""What does the motions of an investigation, what it may do, and who permits it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.excite import Limits, Reference
from lagrangian_ff.diagnosis.excite.keeping import Clear
from lagrangian_ff.errors import UserError
from lagrangian_ff.identification import Model
from lagrangian_ff.progress import Progress
from lagrangian_ff.recording import Conditioning, Recording


class StoppedError(UserError):
    """The arm was stopped: by the user, an alarm, or a controller that refused."""


class Rig(Protocol):
    """An arm that does motions and is recorded meanwhile.

    Attributes:
        joints: N names, from the base to the tool.
    """

    joints: tuple[str, ...]

    def pose(self) -> Floats:
        """Return (N,) rad, where the arm is."""

    def run(self, motion: Reference, model: Model | None, progress: Progress) -> Recording:
        """Do a motion from its first point to its last, and return what was measured.

        Args:
            model: what is known so far, to watch for touches; None for nothing.

        Raises:
            StoppedError: the arm was stopped on the way; it stands still then.
        """


@dataclass(frozen=True)
class Proposal:
    """What an investigation wants to do: the first motion, or one with a larger range.

    Attributes:
        joints: N names.
        start: (N,) rad, where every motion begins and ends.
        limits: that no motion leaves until the next proposal.
        share: of the way from the start to the limits that the user gave.
        seconds: of motion that are left.
    """

    joints: tuple[str, ...]
    start: Floats
    limits: Limits
    share: float
    seconds: float

    @property
    def words(self) -> str:
        """Return the proposal in a sentence."""
        limits = self.limits
        ranges = [
            f"{name} {limits.q_low[n]:.2f} to {limits.q_high[n]:.2f} rad, "
            f"up to {limits.qd_max[n]:.2g} rad/s"
            for n, name in enumerate(self.joints)
        ]
        return f"asks to move for up to {self.seconds:.0f} s: {'; '.join(ranges)}"


Permit = Callable[[Proposal], bool]
"""Returns whether the arm may move so."""


@dataclass(frozen=True)
class Plan:
    """The limits and the budget of an investigation.

    Attributes:
        limits: that are never left.
        start: (N,) rad, where motions begin and end; None for the pose at the beginning.
        budget: s of motion, all in all.
        reaches: shares of the way from the start to the limits, rising; each must be permitted.
        first: s of the motion at each of these.
        each: s of a designed motion, at most.
        size: share of a joint's torque from which on an effect should be seen.
        model: kernel and effects to begin with; empty for the usual ones.
        conditioning: how recordings are made ready.
        clear: whether a path touches anything; None where nobody knows.
        gears: by joint, the kind of its gear as `effects.usual` knows it; what is usual in it is
            asked for first.
        unlisted: whether what no effect fits is taken in as curves, and formulas are proposed.
        seed: of what is random.
    """

    limits: Limits
    start: Floats | None = None
    budget: float = 240.0
    reaches: tuple[float, ...] = (0.5, 1.0)
    first: float = 30.0
    each: float = 30.0
    size: float = 0.02
    model: str = ""
    conditioning: Conditioning = field(default_factory=Conditioning)
    clear: Clear | None = None
    gears: Mapping[str, str] = field(default_factory=dict)
    unlisted: bool = True
    seed: int = 0
