"""Joint states as they come, filtered to states at which a model predicts.

Recordings are filtered forward and backward by a Butterworth low-pass, which squares its gain and
leaves no delay. Of a stream only the past is known, so the same filter is passed twice forward: it
has the same gain at every frequency, so that residuals keep their size, and delays all signals
alike.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil

import numpy as np

from lagrangian_ff import budget
from lagrangian_ff.arrays import Floats
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateView, MessageError
from lagrangian_ff.recording import Conditioning
from lagrangian_ff.recording.bandwidth import USUAL
from lagrangian_ff.recording.filtering import settling
from lagrangian_ff.recording.units import factor_of

STEP = 0.5
"""Longest step, in units of 1 / (2π bandwidth): the Taylor series below is exact to 1e-9 there."""
TERMS = 12
MEASURED = 50
"""Number of periods that the sampling rate is measured from."""
OTHER = 2.0
"""Ratio of the measured period to the filter's, either way, at which the filter is replaced."""
JUMP = 1.0  # s; stamps that go farther, or back as far, are of another clock or after a pause


class CausalFilter:
    """A Butterworth low-pass twice in a row, and the derivatives of its output.

    The state is the output and its derivatives, x' = A x + B u in time scaled by 2π bandwidth, and
    is solved for inputs that are linear between samples, however they are spaced.

    Args:
        order: of the low-pass.
        bandwidth: Hz, where it passes half (1/√2 twice).

    Attributes:
        delay: s by which slow signals are late.
        settled: s after which the output no longer depends on the start.
    """

    def __init__(self, order: int, bandwidth: float) -> None:
        angles = np.pi * (np.arange(1, 2 * order, 2) + order) / (2 * order)
        once = np.poly(np.exp(1j * angles)).real  # the poles lie on a half circle
        twice = np.convolve(once, once)
        size = len(twice) - 1
        self._scale = 2.0 * np.pi * bandwidth
        # Below the state stand the input and its slope.
        self._system = np.zeros((size + 2, size + 2))
        self._system[: size - 1, 1:size] = np.eye(size - 1)
        self._system[size - 1, :size] = -twice[:0:-1]
        self._system[size - 1, size] = 1.0
        self._system[size, size + 1] = 1.0
        self._size = size
        self._state: Floats = np.zeros((size + 2, 0))
        self._step, self._advance = 0.0, np.eye(size + 2)
        self.delay = float(twice[-2] / twice[-1]) / self._scale
        self.settled = 2.0 * settling(order, bandwidth)

    def start(self, values: Floats) -> None:
        """Start with signals (S,) that are assumed constant until now."""
        self._state = np.zeros((self._size + 2, len(values)))
        self._state[0] = self._state[self._size] = values

    def take(self, passed: float, values: Floats) -> None:
        """Take the next sample (S,), `passed` s after the last."""
        scaled = passed * self._scale
        count = max(1, ceil(scaled / STEP))
        self._state[self._size + 1] = (values - self._state[self._size]) / scaled
        advance = self._over(scaled / count)
        for _ in range(count):
            self._state = advance @ self._state

    def output(self) -> tuple[Floats, Floats, Floats]:
        """Return the signals (S,) and their first and second derivative by time."""
        x, scale = self._state, self._scale
        return x[0].copy(), scale * (self._system[0] @ x), scale**2 * (self._system[1] @ x)

    def _over(self, step: float) -> Floats:
        """Return the matrix exponential of a step in scaled time; a steady clock needs it once."""
        if step != self._step:
            term = advance = np.eye(self._size + 2)
            for k in range(1, TERMS + 1):
                term = term @ self._system * (step / k)
                advance = advance + term
            self._step, self._advance = step, advance
        return self._advance


@dataclass(frozen=True)
class State:
    """The filtered measurement at one instant.

    Attributes:
        at: ns, the instant of the filtered values.
        segment: changes at each interruption of the stream.
        bridged: whether a straight line over a hole in the stream is part of it.
        q: (N,) rad.  qd: (N,) rad/s.  qdd: (N,) rad/s².  tau: (N,) N·m.
    """

    at: int
    segment: int
    bridged: bool
    q: Floats
    qd: Floats
    qdd: Floats
    tau: Floats


class LiveStates:
    """Filters position and effort alike and returns states at a lower rate.

    A pause longer than recordings may have, or stamps that jump back, begin a new segment: the
    filter restarts and returns nothing until it has settled. A straight line bridges a shorter
    hole, and the states that it is part of say so.

    Args:
        joints: N names of the model.
        conditioning: that of the model's recordings.
        rate: Hz of the returned states, at most that of the messages.

    Attributes:
        gaps: number of interruptions so far.
        period: median s between messages; 0 until enough have come.
        bandwidth: Hz of the low-pass; 0 until it is known.
        delay: s by which the states are later than the messages.
    """

    def __init__(self, joints: tuple[str, ...], conditioning: Conditioning, rate: float) -> None:
        self._joints = joints
        self._conditioning = conditioning
        self._angle = factor_of(conditioning.units, "position")
        self._scale = _by_joint(conditioning.effort_scale, joints, 1.0)
        self._scale *= factor_of(conditioning.units, "effort")
        self._offset = _by_joint(conditioning.effort_offset, joints, 0.0)
        self._every = round(1e9 / rate)
        self._filter: CausalFilter | None = None
        self._names: tuple[str, ...] = ()
        self._columns: list[int] = []
        self._steps: list[int] = []
        self._last = 0
        self._began = 0
        self._segment = 0
        self._longest = self._hole = 0.0
        self._bridged = 0
        self.gaps = 0
        self.period = self.bandwidth = self.delay = 0.0

    def take(self, view: JointStateView, received: int) -> State | None:
        """Take a message and return a state if one is due.

        Args:
            received: time of reception in ns, for drivers that do not stamp.

        Raises:
            MessageError: it cannot be used.
        """
        values = self._values(view)
        if values is None:
            return None
        at = view.stamp or received
        last, passed = self._last, (at - self._last) / 1e9
        if last and -JUMP < passed <= 0.0:
            raise MessageError("a joint state that is not newer than the one before")
        self._last = at
        if last and 0.0 < passed < JUMP:
            self._steps.append(at - last)
        if len(self._steps) == MEASURED:
            period = float(np.median(self._steps)) / 1e9
            self._steps.clear()
            if self._filter is None or not 1.0 / OTHER < period / self.period < OTHER:
                self._filter = self._designed(period)
                self._start(self._filter, values, at)
                return None
        if self._filter is None:
            return None
        if passed <= 0.0 or passed > self._longest:
            self.gaps += 1
            self._start(self._filter, values, at)
            return None
        if passed > self._hole:
            self._bridged = at
        self._filter.take(passed, values)
        due = at // self._every != last // self._every
        if not due or (at - self._began) / 1e9 < self._filter.settled:
            return None
        y, yd, ydd = self._filter.output()
        count = len(self._joints)
        behind = at - round(self._filter.delay * 1e9)
        bridged = (at - self._bridged) / 1e9 < self._filter.settled
        tau = y[count:] + self._conditioning.effort_delay * yd[count:]
        return State(behind, self._segment, bridged, y[:count], yd[:count], ydd[:count], tau)

    def _values(self, view: JointStateView) -> Floats | None:
        """Return positions and torques (2N,), or None for another part of the robot."""
        if view.names != self._names:
            columns = view.columns(self._joints)
            if not columns:
                return None
            self._names, self._columns = view.names, columns
        if len(view.position) == 0 or len(view.effort) == 0:
            lacking = "positions" if len(view.position) == 0 else "effort"
            raise MessageError(f"joint states without {lacking}: there is nothing to compare")
        values = np.concatenate(
            [
                view.position[self._columns] * self._angle,
                view.effort[self._columns] * self._scale + self._offset,
            ]
        )
        sound = np.abs(values) <= budget.LARGEST
        if not sound.all():
            index = int(sound.argmin())
            kind, joint = divmod(index, len(self._joints))
            raise MessageError(
                f"a joint state where the {('position', 'effort')[kind]} of {self._joints[joint]} "
                f"is {values[index]:g}"
            )
        return values

    def _designed(self, period: float) -> CausalFilter:
        """Return the filter that recordings with this period, s, would get."""
        self.period = period
        # As long as the gaps that are bridged in recordings.
        self.bandwidth = min(self._conditioning.bandwidth or USUAL, 0.25 / self.period)
        usual = max(0.5 / self.bandwidth, 2.5 * self.period)
        self._longest = self._conditioning.max_gap or usual
        # Over a longer step a straight line is not the motion any more.
        self._hole = max(0.25 / self.bandwidth, 1.5 * self.period)
        filter_ = CausalFilter(self._conditioning.order, self.bandwidth)
        self.delay = filter_.delay
        return filter_

    def _start(self, filter_: CausalFilter, values: Floats, at: int) -> None:
        filter_.start(values)
        self._began, self._bridged = at, 0
        self._segment += 1


def _by_joint(known: Mapping[str, float], joints: tuple[str, ...], usual: float) -> Floats:
    return np.array([known.get(joint, usual) for joint in joints])
