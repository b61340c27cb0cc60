"""Where a motion leaves what a model was identified on."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from lagrangian_ff.identification import Model

    Floats = NDArray[np.float64]

MARGIN = 0.05
"""What lies this far outside still counts as inside, in parts of the range."""
SHORT_SECONDS = 0.25
"""Returns into the range that are shorter do not end a span."""


@dataclass(frozen=True)
class Leaving:
    """How much of a motion lies outside, and where.

    Attributes:
        share: of the samples, 0 to 1.
        worst: the joint, quantity and time farthest outside, in words; empty where none is.
        spans: s, from when to when, short returns into the range not counted.
    """

    share: float
    worst: str
    spans: tuple[tuple[float, float], ...]

    def when(self, most: int = 4) -> str:
        """The spans in words."""
        shown = [f"{begin:.2f} to {end:.2f} s" for begin, end in self.spans[:most]]
        more = len(self.spans) - most
        return ", ".join(shown) + (f" and {more} more times" if more > 0 else "")


def leaving(model: "Model", time: "Floats", states: "tuple[Floats, Floats, Floats]") -> Leaving:
    """Compare a motion with the range of a model.

    Args:
        model: the model.
        time: (M,) s.
        states: q, qd, qdd of the model's joints, (M, N) each.
    """
    import numpy as np

    from lagrangian_ff.nodes.streaming.ranges import excess

    found = excess(model.joints, time, states, model.range, MARGIN)
    times = time[found.outside]
    breaks = np.flatnonzero(~((np.diff(times) >= 0.0) & (np.diff(times) < SHORT_SECONDS)))
    spans = tuple(
        (float(part[0]), float(part[-1])) for part in np.split(times, breaks + 1) if len(part)
    )
    return Leaving(float(np.mean(found.outside)) if len(time) else 0.0, found.worst, spans)
