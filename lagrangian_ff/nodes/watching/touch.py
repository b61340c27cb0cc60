"""An alarm for a collision, or a load that is taken up, within a tenth of a second.

Filters of several lengths take the mean residual of the last states less that shortly before. A
touch changes it at once. What counts is that change in parts of what is usual, in two ways: of what
the model errs with by itself (`jumps`), and, where the arm was before, of what came then
(`familiar`). The alarm is raised where chance would hardly raise it in an hour (`chance`).
"""

from dataclasses import dataclass

import numpy as np

from lagrangian_ff.identification import Model
from lagrangian_ff.kernels import States
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.watching.chance import LEARNING, Chance
from lagrangian_ff.nodes.watching.familiar import Familiar
from lagrangian_ff.nodes.watching.jumps import LENGTHS, Errors, Filters
from lagrangian_ff.nodes.watching.live import Judged

MEDIAN = 0.6745
"""Of the absolute value of a normal variable."""
SETTLING = 10.0
"""s of motion in which the noise is found that live motion has and training motion had not."""
FOLLOWING = 0.003
"""Share by which one state may change that noise: the median output is then as expected."""
SHOWN = 5.0
"""s for which the status shows a touch."""
OVER = 1.0
"""s without an output above the threshold after which a touch has ended."""


@dataclass(frozen=True)
class Touch:
    """A touch of the arm.

    Attributes:
        at: ns, the stamp about which it began.
        noticed: ns, the stamp of the state that showed it.
        joint: that shows it best.
        torque: N·m that the actuator gave beyond what the motion took.
        strength: output over the threshold.
    """

    at: int
    noticed: int
    joint: str
    torque: float
    strength: float


class TouchAlarm:
    """Raises the alarm, state by state.

    A joint is not judged where its position or speed lies outside the range that the model knows.
    None is judged in states that bridge a hole, nor before `LEARNING` seconds of motion were seen.
    States that the arm was in before are judged by what came then, too, after as many seconds of
    such.

    Args:
        model: of the states' joints.
        step: s between states.

    Attributes:
        judged: s of motion that were judged.
        touches: number of touches so far.
        last: the latest one.
    """

    def __init__(self, model: Model, step: float) -> None:
        count = len(model.joints)
        self._joints, self._range, self._step = model.joints, model.range, step
        self._errors, self._filters = Errors.of(model), Filters(model, step)
        self._familiar = Familiar(model, len(LENGTHS))
        self._more = self._errors.least.copy()
        self._count = 0
        self._outside = np.zeros(count, dtype=np.int64)
        self._segment = self._above = self._now = -1
        self._by_model = Chance(count, 0.5, self._errors.blocks)
        self._by_visits = Chance(count, 0.5)
        self.judged, self.touches = 0.0, 0
        self.last: Touch | None = None

    def add(self, one: Judged, margin: float) -> Touch | None:
        """Take one more instant; return a touch when it is first seen.

        Args:
            margin: how far outside still counts as inside, as a fraction of the identified range.
        """
        state = one.state
        self._now = state.at
        if state.segment != self._segment:
            self._segment = state.segment
            self._filters.restart()
        seen = self._filters.take(state.at / 1e9, state.q, state.qd, state.qdd, one.residual)
        # A touch itself takes the acceleration out of the range.
        away = self._range.excess(States(state.q[None], state.qd[None], 0.0 * state.qdd[None]))[0]
        self._outside = np.where(away > margin, self._filters.size, self._outside - 1)
        if seen is None or state.bridged or not self._errors.parts.size:
            return None
        inside = self._outside <= 0
        self.judged += self._step * float(inside.any())
        z = np.abs(seen.output) / self._errors.scale(seen, self._more)
        self._count += 1
        pace = max(FOLLOWING, 3.0 / (self._count + 10.0))  # quick at first
        change = np.where(inside, np.exp(pace * np.sign(z - MEDIAN)), 1.0)
        self._more = np.maximum(self._more * change, self._errors.least)
        z = np.where(inside, z, 0.0)
        ratio = z / self._by_model.threshold
        again = self._familiar.take(state.at, state.q, state.qd, seen.output)
        if again is not None:
            ratio = np.maximum(ratio, again / self._by_visits.threshold)
        alarm = bool(ratio.max() > 1.0)
        if self.judged > SETTLING:
            self._by_model.take(state.at, z.max(axis=0), inside, alarm)
        if again is not None:
            self._by_visits.take(state.at, again.max(axis=0), np.ones_like(inside), alarm)
        if not alarm:
            return None
        f, n = divmod(int(np.argmax(ratio)), len(self._joints))
        new = self._above < 0 or abs(state.at - self._above) > OVER * 1e9
        self._above = state.at
        if not new:
            return None
        began = state.at - round(LENGTHS[f] * 1e9)
        self.last = Touch(
            began, state.at, self._joints[n], float(seen.output[f, n]), float(ratio[f, n])
        )
        self.touches += 1
        return self.last

    def status(self) -> Status:
        """Return whether the arm was touched in the last seconds of its stamps."""
        values: dict[str, object] = {"touches": self.touches, "judged [s]": self.judged}
        if self._by_model.learned < LEARNING:
            done = f"{self._by_model.learned} of {LEARNING} s"
            return Status(Level.OK, f"learning what is usual: {done}; no alarm yet", values)
        last = self.last
        thresholds = self._by_model.threshold, self._by_visits.threshold
        values |= {
            f"alarm above {joint}": f"{one:.3g} times what is usual"
            + (f", {again:.3g} where it was before" if np.isfinite(again) else "")
            for joint, one, again in zip(self._joints, *thresholds, strict=True)
        }
        if last is None:
            return Status(Level.OK, "no touch so far", values)
        values |= {"last touch [s]": f"{last.at / 1e9:.3f}", "last touched": last.joint}
        if abs(self._now - last.noticed) > SHOWN * 1e9:
            return Status(Level.OK, f"no touch for {abs(self._now - last.at) / 1e9:.0f} s", values)
        return Status(
            Level.WARN,
            f"touched at {last.at / 1e9:.3f} s: {last.joint} gives {last.torque:+.3g} N·m beyond "
            f"what the motion takes, {last.strength:.2g} times the threshold of chance",
            values,
        )

    def forget(self) -> None:
        """Drop the last states: nothing came for too long."""
        self._segment = -1
