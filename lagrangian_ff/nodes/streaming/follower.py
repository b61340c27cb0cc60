"""Which reference the arm is at now, and that it never jumps."""

import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.nodes.common.errors import RefusedReference
from lagrangian_ff.nodes.streaming.reference import Reference

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Segment:
    """A reference with its start.

    Attributes:
        reference: what to follow.
        start: ns.
        effort: (K, N) N·m at its points, linear between them; None where it carries none.
    """

    reference: Reference
    start: int
    effort: Floats | None = None

    def at(self, now: int) -> tuple[Floats, Floats, Floats]:
        """q, qd, qdd, each (N,), at this time in ns."""
        return self.reference.sample(np.asarray((now - self.start) / 1e9))

    def effort_at(self, now: int) -> Floats:
        """(N,) N·m at this time in ns, the ends held outside; zeros without effort."""
        if self.effort is None:
            return np.zeros(len(self.reference.joints))
        time = self.reference.time
        elapsed = np.clip((now - self.start) / 1e9, time[0], time[-1])
        right = min(int(np.searchsorted(time, elapsed, side="right")), len(time) - 1)
        left = max(right - 1, 0)
        span = time[right] - time[left]
        share = (elapsed - time[left]) / span if span > 0.0 else 0.0
        return np.asarray(self.effort[left] * (1.0 - share) + self.effort[right] * share)


class Follower:
    """Follows one reference after another; stands still where there is none.

    References may be accepted in one thread while another asks where to be.

    Args:
        joints: N names.
        q: (N,) rad where it stands at first.
        tolerance: rad by which a new reference may differ from the present one where it
            takes over.
    """

    def __init__(self, joints: tuple[str, ...], q: Floats, tolerance: float) -> None:
        still = np.zeros((1, len(joints)))
        self._now = Segment(Reference(joints, np.zeros(1), q[None, :], still, still), 0)
        self._next: Segment | None = None
        self.tolerance = tolerance
        self._lock = threading.Lock()

    def accept(self, segment: Segment, now: int) -> None:
        """Follow this from its start on, in place of what would have been followed then.

        Raises:
            RefusedReference: the position would jump there, or it is over already.
        """
        reference = segment.reference
        end = segment.start + round(reference.duration * 1e9)
        if not reference.is_setpoint and end < now:
            raise RefusedReference(
                f"it ended {(now - end) / 1e9:.3f} s ago; give a start in header.stamp that is "
                "still to come, or 0 for now"
            )
        takes_over = max(segment.start, now)
        jump = segment.at(takes_over)[0] - self._now.at(takes_over)[0]
        worst = int(np.argmax(np.abs(jump)))
        if abs(jump[worst]) > self.tolerance:
            late = (now - segment.start) / 1e9
            raise RefusedReference(
                f"{reference.joints[worst]} would jump by {jump[worst]:.4f} rad from the present "
                f"reference, more than the tolerance of {self.tolerance:g} rad; "
                + (
                    f"it came {late:.3f} s after its start: send it earlier"
                    if late > 0.0
                    else "start where the arm is"
                )
            )
        with self._lock:
            self._next = segment

    def at(self, now: int) -> tuple[Floats, Floats, Floats, Floats]:
        """q, qd, qdd and effort of the reference, each (N,), at this time in ns."""
        with self._lock:
            if self._next is not None and now >= self._next.start:
                self._now, self._next = self._next, None
        return (*self._now.at(now), self._now.effort_at(now))

    @property
    def has_effort(self) -> bool:
        """Whether what is followed now carries effort."""
        return self._now.effort is not None

    def moving(self, now: int) -> bool:
        """Whether it is under way or about to be."""
        segment = self._next or self._now
        return now < segment.start + segment.reference.duration * 1e9
