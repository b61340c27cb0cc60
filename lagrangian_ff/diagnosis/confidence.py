"""The verdict on a finding, the reason to doubt it, and how it did on motion held out."""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from lagrangian_ff.arrays import Floats


class Verdict(str, Enum):
    """The certainty of a finding; JSON holds its value."""

    CONFIRMED = "confirmed"
    AMBIGUOUS = "ambiguous"
    SUGGESTED = "suggested"


class Reason(Enum):
    """The reason why a finding is only suggested."""

    TOO_SHORT = "the motion held out is too short, or hardly shows the effect"
    NOT_HELD_OUT = "it does not help on most of the motion held out"
    OTHER_SIZE = "it has another size on the motion held out"
    LARGE_REST = "a curve explains nearly as much on the joint"
    ABSORBED = "the model may have this torque already"
    AT_END = "a shape ends where its range ends"
    IMPOSSIBLE = "no hardware surely has these parameters"
    ONCE = "it happens once in a recording, and there is no second one"
    NEAR_REVERSALS = "it shows near reversals only, where hysteresis leaves as much"
    NOT_AGAIN = "another recording does not show it"
    OTHER_KIND = "another recording shows a change of another kind"
    NO_HELP = "it is there, but adding it does not lower the error of this model"


@dataclass(frozen=True)
class Doubt:
    """A reason with its figures.

    Attributes:
        reason: for a program.  words: for a person.
    """

    reason: Reason
    words: str


@dataclass(frozen=True, eq=False)
class HoldOut:
    """The judgement of a frozen effect on motion that was not used to find it.

    Attributes:
        expected: (G,) expected log Bayes factor in nats of each group of blocks, if it is as found.
        gained: (G,) the log Bayes factor in nats of each group.
        ratio: its size on this motion relative to that found, 1 if it is the same.
        p_value: of Wilcoxon's signed-rank test of `gained`.
        doubt: why it does not hold; None if it does.
    """

    expected: Floats
    gained: Floats
    ratio: float
    p_value: float
    doubt: Doubt | None

    @property
    def holds(self) -> bool:
        """Return whether it helps on most of the motion, significantly and at the size found."""
        return self.doubt is None

    @property
    def share(self) -> float:
        """Return the share of groups in which it helps."""
        return float(np.mean(self.gained > 0.0)) if len(self.gained) else 0.0
