"""Where the joints are now, from joint states that may come in parts."""

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateView

STALE = 0.5  # s without a joint state
BACK = 0.3  # s that are looked back on for movement
FEWEST = 3
"""Joint states within that time that show whether a joint stands."""
STANDING = 0.01  # rad within which a joint that stands stays


@dataclass
class _Part:
    """The newest joint states of one layout."""

    seen: deque[tuple[int, Floats]] = field(default_factory=deque)
    heard: float = 0.0


class Poses:
    """The newest position of every joint. Any thread may ask.

    Args:
        clock: s, monotonic.

    Attributes:
        at: ns, the newest stamp.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._parts: dict[tuple[str, ...], _Part] = {}
        self.at = 0
        self._lock = threading.RLock()

    def take(self, view: JointStateView, at: int) -> None:
        """Take a joint state with finite positions, stamped or received at `at`, ns."""
        with self._lock:
            part = self._parts.setdefault(view.names, _Part())
            if part.seen and at < part.seen[-1][0]:
                part.seen.clear()  # the clock was set back
            part.seen.append((at, view.position))
            while (at - part.seen[0][0]) / 1e9 > BACK:
                part.seen.popleft()
            part.heard, self.at = self._clock(), at

    @property
    def joints(self) -> tuple[str, ...]:
        """Return the names of the joints that are heard of now."""
        now = self._clock()
        with self._lock:
            parts = [names for names, part in self._parts.items() if now - part.heard < STALE]
        return tuple(dict.fromkeys(name for names in parts for name in names))

    def now(self, joints: Sequence[str]) -> Floats:
        """Return the positions (N,) rad of joints.

        Raises:
            UserError: there is no such joint, or nothing was heard of it lately.
        """
        with self._lock:
            found = self._columns(joints)
            return np.array([self._part(joint).seen[-1][1][k] for joint, k in found])

    def standing(self, joints: Sequence[str]) -> Floats:
        """Return the positions (N,) rad of joints that stand still.

        Raises:
            UserError: there is no such joint, too little was heard of it lately to know that it
                stands, or it moves.
        """
        with self._lock:
            for joint, k in self._columns(joints):
                if len(self._part(joint).seen) < FEWEST:
                    raise UserError(f"too few joint states of {joint} to see whether it stands")
                values = [position[k] for _, position in self._part(joint).seen]
                if max(values) - min(values) > STANDING:
                    raise UserError(f"{joint} moves now: wait until the arm stands")
            return self.now(joints)

    def _columns(self, joints: Sequence[str]) -> list[tuple[str, int]]:
        known = {name for names in self._parts for name in names}
        unknown = [joint for joint in joints if joint not in known]
        if unknown:
            heard = f"they are of {', '.join(sorted(known))[:200]}" if known else "none came"
            raise UserError(f"no joint states of {', '.join(unknown)}: {heard}")
        now = self._clock()
        found = []
        for joint in joints:
            age = now - self._part(joint).heard
            if age > STALE:
                raise UserError(f"the joint states are stale: none of {joint} for {age:.1f} s")
            found.append((joint, self._names(joint).index(joint)))
        return found

    def _names(self, joint: str) -> tuple[str, ...]:
        """Return the layout that was heard last of those with this joint."""
        layouts = (names for names in self._parts if joint in names)
        return max(layouts, key=lambda names: self._parts[names].heard)

    def _part(self, joint: str) -> _Part:
        return self._parts[self._names(joint)]
