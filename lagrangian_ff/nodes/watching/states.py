"""From joint states as they come to states at which a model can be asked."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.nodes.common.errors import MessageError
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateView
from lagrangian_ff.nodes.watching.causal import CausalFilter
from lagrangian_ff.recording import Conditioning

Floats = NDArray[np.float64]

MEASURED = 50
"""Periods from which the sampling rate is told."""
JUMP = 1.0  # s; stamps that go back farther are another clock, not a message that came late


@dataclass(frozen=True)
class State:
    """What was measured at one instant, filtered.

    Attributes:
        at: ns; of the instant that the filtered values tell of.
        segment: changes whenever the stream was interrupted.
        q: (N,) rad.  qd: (N,) rad/s.  qdd: (N,) rad/s².  tau: (N,) N·m.
    """

    at: int
    segment: int
    q: Floats
    qd: Floats
    qdd: Floats
    tau: Floats


class LiveStates:
    """Filters position and effort alike and gives states at a lower rate.

    A pause longer than recordings may have, or stamps that jump back, begin a new segment: the
    filter starts anew and gives nothing until it has settled.

    Args:
        joints: N names of the model.
        conditioning: how the recordings of the model were treated.
        rate: Hz of the states that are given, at most that of the messages.

    Attributes:
        gaps: interruptions so far.
        period: s between messages in the median; 0 until enough have come.
        bandwidth: Hz of the low-pass; 0 until it is known.
        delay: s by which the states lie behind the messages.
    """

    def __init__(self, joints: tuple[str, ...], conditioning: Conditioning, rate: float) -> None:
        self._joints = joints
        self._conditioning = conditioning
        self._scale = _by_joint(conditioning.effort_scale, joints, 1.0)
        self._offset = _by_joint(conditioning.effort_offset, joints, 0.0)
        self._every = round(1e9 / rate)
        self._filter: CausalFilter | None = None
        self._names: tuple[str, ...] = ()
        self._columns: list[int] = []
        self._steps: deque[int] = deque(maxlen=MEASURED)
        self._last = 0
        self._began = 0
        self._segment = 0
        self._longest = 0.0
        self.gaps = 0
        self.period = self.bandwidth = self.delay = 0.0

    def take(self, view: JointStateView, received: int) -> State | None:
        """Take a message; a state where one is due.

        Args:
            view: the message.
            received: ns when it came, for drivers that do not stamp.

        Raises:
            MessageError: it cannot be used; says why.
        """
        values = self._values(view)
        if values is None:
            return None
        at = view.stamp or received
        last, passed = self._last, (at - self._last) / 1e9
        if last and -JUMP < passed <= 0.0:
            raise MessageError("a joint state that is not newer than the one before")
        self._last = at
        if self._filter is None:
            if last and passed > 0.0:
                self._steps.append(at - last)
            if len(self._steps) == MEASURED:
                self._filter = self._designed()
                self._start(self._filter, values, at)
            return None
        if passed <= 0.0 or passed > self._longest:
            self.gaps += 1
            self._start(self._filter, values, at)
            return None
        self._filter.take(passed, values)
        due = at // self._every != last // self._every
        if not due or (at - self._began) / 1e9 < self._filter.settled:
            return None
        y, yd, ydd = self._filter.output()
        count = len(self._joints)
        behind = at - round(self._filter.delay * 1e9)
        return State(behind, self._segment, y[:count], yd[:count], ydd[:count], y[count:])

    def _values(self, view: JointStateView) -> Floats | None:
        """(2N,) positions and torques; None where the message is of another part of the robot."""
        if view.names != self._names:
            missing = [joint for joint in self._joints if joint not in view.names]
            if len(missing) == len(self._joints):
                return None
            if missing:
                raise MessageError(f"joint states without {', '.join(missing)}")
            self._names = view.names
            self._columns = [view.names.index(joint) for joint in self._joints]
        if len(view.position) == 0 or len(view.effort) == 0:
            lacking = "positions" if len(view.position) == 0 else "effort"
            raise MessageError(f"joint states without {lacking}: there is nothing to compare")
        values = np.concatenate(
            [view.position[self._columns], view.effort[self._columns] * self._scale + self._offset]
        )
        if not np.isfinite(values).all():
            kind, joint = divmod(int(np.isfinite(values).argmin()), len(self._joints))
            raise MessageError(
                f"a joint state where the {('position', 'effort')[kind]} of {self._joints[joint]} "
                "is not finite"
            )
        return values

    def _designed(self) -> CausalFilter:
        """The filter that recordings of this sampling rate would get."""
        self.period = float(np.median(self._steps)) / 1e9
        # As long as the gaps that are bridged in recordings.
        self.bandwidth = min(self._conditioning.bandwidth, 0.25 / self.period)
        usual = max(0.5 / self.bandwidth, 2.5 * self.period)
        self._longest = self._conditioning.max_gap or usual
        filter_ = CausalFilter(self._conditioning.order, self.bandwidth)
        self.delay = filter_.delay
        return filter_

    def _start(self, filter_: CausalFilter, values: Floats, at: int) -> None:
        filter_.start(values)
        self._began = at
        self._segment += 1


def _by_joint(known: Mapping[str, float], joints: tuple[str, ...], usual: float) -> Floats:
    return np.array([known.get(joint, usual) for joint in joints])
