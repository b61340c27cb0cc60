"""What a part of a node says about itself, before it becomes a message."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum


class Level(IntEnum):
    """The levels of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class Status:
    """How it goes, in a sentence and in figures.

    Numbers among the values are shown with six digits.
    """

    level: Level
    message: str
    values: Mapping[str, object] = field(default_factory=dict)

    def texts(self) -> dict[str, str]:
        """The values as text."""
        return {
            key: f"{value:.6g}" if isinstance(value, float) else str(value)
            for key, value in self.values.items()
        }
