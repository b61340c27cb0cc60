"""Motions to begin a design with: the templates, and strokes at two speeds."""

from collections.abc import Iterator, Sequence

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.excite.excite import SHORTEST, excite
from lagrangian_ff.diagnosis.excite.motions import NEXT_MOTIONS
from lagrangian_ff.diagnosis.excite.path import Limits, Reference
from lagrangian_ff.effects import MOTIONS

SHARES = (1.0, 0.85, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0)
"""Shares of the duration that templates are asked for."""
SPEEDS = (0.03, 0.1, 0.3, 0.8)
"""Shares of the highest speed of strokes."""
WIDTHS = (0.1, 0.4, 0.9)
"""Shares of a joint's range that strokes take."""


def starts_of(
    joints: Sequence[str],
    wanted: Sequence[str],
    limits: Limits,
    start: Floats,
    seconds: float,
    seed: int,
) -> Iterator[tuple[str, Floats]]:
    """Yield names and positions (M, N) rad of motions, each to be spread over the duration.

    Args:
        wanted: the joints to look at.  start: (N,) rad.  seconds: the duration.
    """
    for motion in MOTIONS:
        for joint in wanted if NEXT_MOTIONS[motion].one_each else [None]:
            made = template(motion, joints, limits, joint, start, seconds, seed)
            yield f"{motion} {joint or ''}".strip(), made.q
    for joint in wanted:
        n = list(joints).index(joint)
        for slow in SPEEDS[:2]:
            for fast in SPEEDS[2:]:
                for width in WIDTHS:
                    speeds = slow * limits.qd_max[n], fast * limits.qd_max[n]
                    yield (
                        f"strokes {joint}",
                        strokes(limits, start, n, speeds, width * limits.width[n], seconds),
                    )


def template(
    motion: str,
    joints: Sequence[str],
    limits: Limits,
    joint: str | None,
    start: Floats,
    seconds: float,
    seed: int = 0,
) -> Reference:
    """Return the longest motion of a name that is over after `seconds`, or the shortest there is.

    What is asked for as duration leaves out the ways between its parts.
    """
    for share in SHARES:
        asked = max(share * seconds, SHORTEST)
        made = excite(motion, joints, limits, joint=joint, start=start, duration=asked, seed=seed)
        if made.time[-1] <= seconds or asked == SHORTEST:
            break
    return made


def strokes(
    limits: Limits,
    start: Floats,
    joint: int,
    speeds: tuple[float, float],
    width: float,
    seconds: float,
) -> Floats:
    """Return (M, N) rad: a joint to and fro, half of the time at each of two speeds."""
    time = np.linspace(0.0, 0.5 * seconds, max(50, round(25 * seconds)))
    low = np.clip(start[joint] - 0.5 * width, limits.q_low[joint], limits.q_high[joint] - width)
    track = []
    for speed in speeds:
        # A triangle from `start` on, between low and low + width.
        way = speed * time + (start[joint] - low)
        track.append(low + width - np.abs(np.mod(way, 2.0 * width) - width))
    q = np.tile(start, (2 * len(time), 1))
    q[:, joint] = np.clip(
        np.concatenate([track[0], track[1]]), limits.q_low[joint], limits.q_high[joint]
    )
    return q
