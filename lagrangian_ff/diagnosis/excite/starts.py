"""Motions to begin a design with: the templates, and strokes at a few speeds."""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.excite.excite import SHORTEST, excite
from lagrangian_ff.diagnosis.excite.motions import NEXT_MOTIONS, there_and_back
from lagrangian_ff.diagnosis.excite.path import REST, Limits, Path, Reference
from lagrangian_ff.effects import MOTIONS

SHARES = (1.0, 0.85, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0)
"""Shares of the duration that templates are asked for."""
SLOWEST = (0.03, 0.1, 0.3)
"""Shares of the highest speed that the slowest strokes have."""
COUNTS = (2, 5)
"""Numbers of speeds that strokes are made with: each is the one before times the same factor."""
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
        for slow, count, width in product(SLOWEST, COUNTS, WIDTHS):
            speeds = limits.qd_max[n] * np.geomspace(slow, 1.0, count)
            q = strokes(limits, start, n, speeds.tolist(), width * limits.width[n], seconds)
            yield f"strokes {joint}", q


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
    limits: Limits, start: Floats, joint: int, speeds: Sequence[float], width: float, seconds: float
) -> Floats:
    """Return (M, N) rad: a joint to and fro, about as long at each of some speeds."""
    path = Path(start, limits)
    low = np.clip(start[joint] - 0.5 * width, limits.q_low[joint], limits.q_high[joint] - width)
    path.move_joint(joint, float(low))
    each = seconds / len(speeds)
    for speed in speeds:
        way = min(width, 0.4 * each * speed)
        for _ in range(max(1, int(0.5 * each / (way / speed + REST)))):
            there_and_back(path, joint, way, speed)
    path.move(start)
    return path.reference().q
