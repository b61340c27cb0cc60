"""An alarm for a collision, or a load that is taken up, within a tenth of a second.

Filters of several lengths take the mean residual of the last states less that shortly before. A
touch changes it at once. What a model errs with by itself changes it too: about reversals, in
creeping, with speed and position, and with noise. How much is learned from the model's training
motion, as components of a variance (`diagnosis.bursts` does it for whole recordings, with windows
to both sides). A touch accelerates the arm, so that acceleration excuses an output only if it was
there before. What counts is the output in parts of what these components give.

The alarm is raised where chance would raise it once in an hour, joint by joint, by the tail of the
largest outputs of each second: of the training motion, and of the last hour.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Flags, Floats
from lagrangian_ff.identification import Model
from lagrangian_ff.kernels import States
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.watching.live import Judged
from lagrangian_ff.sampling import usual_step

LENGTHS = 0.02, 0.04
"""s that the filters look back on."""
GAP = 0.03
"""s left out before, over which the low-pass spreads the beginning of a touch."""
BEFORE = 0.2
"""s before that, which the last are compared with."""
CREEP = 0.1
"""Share of a joint's rms speed below which friction may have any form."""
AFTER = 0.1
"""s after a reversal in which friction settles."""
CHANGES, NOW, EARLIER = 4, 3, 2
"""Causes of a model's errors that count as they change, as they are, and as they were before."""
MOST = 6000
"""States of the training motion that are learned from."""
STEPS = 30
"""Of the climb to the likeliest components of the variance."""
BLOCK = 1.0
"""s, of which the largest output counts."""
HOUR = 3600.0
"""s in which one false alarm may come, and of which the largest outputs are kept."""
LEARNING = 120
"""Blocks of live motion before the first alarm: live, a model errs more than on what it learned."""
ENOUGH = 300
"""Blocks of live motion beside which those of the training motion no longer count."""
TAIL = 0.25
"""Share of the blocks, from the largest output on, that shows how fast the tail falls."""
MEDIAN = 0.6745
"""Of the absolute value of a normal variable."""
SETTLING = 10.0
"""s of motion in which the noise is found that live motion has and training motion had not."""
PACE = 0.003
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
        strength: output over what the model's own errors give there.
    """

    at: int
    noticed: int
    joint: str
    torque: float
    strength: float


class _Sources:
    """What a model errs with, state by state.

    Args:
        model: of N joints; its data say what is much.
    """

    def __init__(self, model: Model) -> None:
        known = model.data
        self._speed, self._hard, self._width = (
            np.maximum(np.sqrt(np.mean(one**2, axis=0)), 1e-9)
            for one in (known.qd, known.qdd, known.q - known.q.mean(axis=0))
        )
        self.restart()

    def restart(self) -> None:
        """Forget the last state."""
        self._last: tuple[float, Floats, Floats] | None = None
        self._settling = np.zeros_like(self._speed)

    def take(self, time: float, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """Return (CHANGES + NOW + EARLIER, N): what counts as it changes, as it is, as it was.

        Args:
            time: s.  q, qd, qdd: (N,) rad, rad/s, rad/s².
        """
        hard, fast = qdd / self._hard, (qd / self._speed) ** 2
        creep = np.exp(-fast / CREEP**2)
        way = np.tanh(qd / (0.5 * CREEP * self._speed))
        jerk = np.zeros_like(q)
        if self._last is not None:
            before, speed, earlier = self._last
            passed = max(time - before, 1e-6)
            jerk = (hard - earlier) / passed
            turned = np.signbit(qd) != np.signbit(speed)
            self._settling = np.where(turned, 1.0, self._settling * np.exp(-passed / AFTER))
        self._last = time, qd, hard
        changes = fast, q / self._width, way, way * creep
        return np.stack([*changes, fast, self._settling, creep, hard**2, jerk**2])


@dataclass(frozen=True)
class _Seen:
    """What the filters see at one state: `output` (F, N) N·m, `shares` (F, K, N)."""

    output: Floats
    shares: Floats


class _Filters:
    """The filters over the last states.

    Args:
        model: of N joints.  step: s between states.

    Attributes:
        size: states that an output needs.
    """

    def __init__(self, model: Model, step: float) -> None:
        self._sources, self._joints = _Sources(model), len(model.joints)
        lengths = [max(1, round(length / step)) for length in LENGTHS]
        gap, before = (max(1, round(length / step)) for length in (GAP, BEFORE))
        self._spans = [(now, now + gap, now + gap + before) for now in lengths]
        self.size = max(span[-1] for span in self._spans)
        # Every row stands twice, so that the last ones always lie in one piece.
        self._rows = np.zeros((2 * self.size, 1 + CHANGES + NOW + EARLIER, self._joints))
        self._count = 0

    def restart(self) -> None:
        """Forget the past."""
        self._count = 0
        self._sources.restart()

    def take(
        self, time: float, q: Floats, qd: Floats, qdd: Floats, residual: Floats
    ) -> _Seen | None:
        """Take a state; return what is seen, None while there are too few.

        Args:
            time: s.  q, qd, qdd: (N,) rad, rad/s, rad/s².  residual: (N,) N·m.
        """
        place = self._count % self.size
        row = np.concatenate([residual[None], self._sources.take(time, q, qd, qdd)])
        self._rows[place] = self._rows[place + self.size] = row
        self._count += 1
        if self._count < self.size:
            return None
        end = place + self.size + 1
        output, shares = [], []
        for now, until, since in self._spans:
            earlier = self._rows[end - since : end - until].mean(axis=0)
            change = self._rows[end - now : end].mean(axis=0) - earlier
            whole = self._rows[end - since : end].mean(axis=0)
            causes = np.concatenate(
                [change[1 : 1 + CHANGES] ** 2, whole[1 + CHANGES : -EARLIER], earlier[-EARLIER:]]
            )
            others = causes.sum(axis=1, keepdims=True) - causes
            output.append(change[0])
            shares.append(np.concatenate([np.ones((1, self._joints)), causes, others]))
        return _Seen(np.stack(output), np.stack(shares))


@dataclass(frozen=True)
class Errors:
    """What a model's errors give in the filters.

    Attributes:
        parts: (F, K, N) the variances of K components.
        least: (F, N) N·m, a tenth of the usual output in the training motion.
        blocks: (B, N) the largest output of each second of the training motion, over what was
            expected.
    """

    parts: Floats
    least: Floats
    blocks: Floats

    @classmethod
    def of(cls, model: Model) -> "Errors":
        """Return those of a model in its own training motion."""
        motion = model.data.take(np.flatnonzero(model.trained)[:MOST])
        residual = motion.tau - model.torque(model.inputs_of(motion))
        step = usual_step(motion.time, motion.segment)
        filters = _Filters(model, step)
        rows, seen = [], []
        for k, time in enumerate(motion.time):
            if k and motion.segment[k] != motion.segment[k - 1]:
                filters.restart()
            here = motion.q[k], motion.qd[k], motion.qdd[k]
            found = filters.take(float(time), *here, residual[k])
            if found is not None:
                rows.append(k)
                seen.append(found)
        if not seen:
            none = np.zeros((len(LENGTHS), 0, len(model.joints)))
            return cls(none, none.sum(axis=1), none[0])
        output = np.stack([one.output for one in seen])
        shares = np.stack([one.shares for one in seen])
        parts = np.stack([_components(output[::2, f], shares[::2, f]) for f in range(len(LENGTHS))])
        scale = np.sqrt(np.einsum("mfkn,fkn->mfn", shares, parts))
        largest = (np.abs(output) / scale).max(axis=1)
        number = np.floor(motion.time[rows] / BLOCK).astype(np.int64)
        starts = np.flatnonzero(np.diff(number, prepend=number[0] - 1))
        least = 0.1 * np.sqrt(np.mean(output**2, axis=0)) + 1e-9
        return cls(parts, least, np.maximum.reduceat(largest, starts))

    def scale(self, seen: _Seen, more: Floats) -> Floats:
        """Return (F, N) N·m that are expected of the outputs at one state.

        Args:
            more: (F, N) N·m, what is there besides, as of noise that training motion did not have.
        """
        learned = np.einsum("fkn,fkn->fn", seen.shares, self.parts)
        return np.asarray(np.sqrt(learned + more**2))


def _components(output: Floats, shares: Floats) -> Floats:
    """Return (K, N) the likeliest variances of the components of outputs (M, N).

    The multiplicative steps are those of Févotte, Bertin and Durrieu 2009, Neural Computation 21.

    Args:
        shares: (M, K, N) what each component may have in the variance of each output.
    """
    mean = np.maximum(shares.mean(axis=0), 1e-100)
    shares, square = shares / mean, output**2
    part = np.maximum(square.mean(axis=0), 1e-24) / len(mean) * np.ones_like(mean)
    for _ in range(STEPS):
        variance = np.einsum("mkn,kn->mn", shares, part)
        more = np.einsum("mn,mkn->kn", square / variance**2, shares)
        less = np.einsum("mn,mkn->kn", 1.0 / variance, shares)
        part = part * more / np.maximum(less, 1e-100)
    return np.asarray(part / mean)


def once_in(seconds: float, blocks: Floats) -> Floats:
    """Return (N,) the output that chance reaches once in some time.

    The tail falls as slowly as that of the largest blocks (Hill 1975, Annals of Statistics 3;
    Weissman 1978, JASA 73), as in `diagnosis.contacts`.

    Args:
        seconds: s.  blocks: (B, N) the largest output of each block.
    """
    ordered = np.maximum(np.sort(blocks, axis=0)[::-1], 1e-9)
    many = min(max(2, round(TAIL * len(ordered))), len(ordered) - 1)
    level = ordered[many]
    slow = np.mean(np.log(ordered[:many] / level), axis=0)
    share = max(seconds / BLOCK * many / len(ordered), 1.0)
    return np.asarray(level * share**slow)


class TouchAlarm:
    """Raises the alarm, state by state.

    A joint is not judged where its position or speed lies outside the range that the model knows,
    and none is until `LEARNING` seconds of motion were seen.

    Args:
        model: of the states' joints.
        step: s between states.

    Attributes:
        judged: s of motion that were judged.
        touches: number of touches so far.
        last: the latest one.
        threshold: (N,) output over what is expected from which on there is an alarm; infinite at
            first.
    """

    def __init__(self, model: Model, step: float) -> None:
        self._joints, self._range, self._step = model.joints, model.range, step
        self._errors, self._filters = Errors.of(model), _Filters(model, step)
        self._more = self._errors.least.copy()
        self._blocks: deque[Floats] = deque(maxlen=round(HOUR / BLOCK))
        self._block, self._largest, self._count = -1, np.zeros(len(model.joints)), 0
        self._outside = np.zeros(len(model.joints), dtype=np.int64)
        self._segment = self._above = self._now = -1
        self.judged, self.touches = 0.0, 0
        self.last: Touch | None = None
        self.threshold = np.full(len(model.joints), np.inf)

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
        if seen is None or not self._errors.parts.size:
            return None
        inside = self._outside <= 0
        self.judged += self._step * float(inside.any())
        z = np.abs(seen.output) / self._errors.scale(seen, self._more)
        self._count += 1
        pace = max(PACE, 3.0 / (self._count + 10.0))  # quick at first
        change = np.where(inside, np.exp(pace * np.sign(z - MEDIAN)), 1.0)
        self._more = np.maximum(self._more * change, self._errors.least)
        z = np.where(inside, z, 0.0)
        if self.judged > SETTLING:
            self._learn(state.at, z.max(axis=0), inside)
        f, n = divmod(int(np.argmax(z / self.threshold)), len(self._joints))
        if z[f, n] <= self.threshold[n]:
            return None
        new = self._above < 0 or abs(state.at - self._above) > OVER * 1e9
        self._above = state.at
        if not new:
            return None
        began = state.at - round(LENGTHS[f] * 1e9)
        torque, strength = float(seen.output[f, n]), float(z[f, n])
        self.last = Touch(began, state.at, self._joints[n], torque, strength)
        self.touches += 1
        return self.last

    def status(self) -> Status:
        """Return whether the arm was touched in the last seconds of its stamps."""
        values: dict[str, object] = {"touches": self.touches, "judged [s]": self.judged}
        if len(self._blocks) < LEARNING:
            done = f"{len(self._blocks)} of {LEARNING} s"
            return Status(Level.OK, f"learning what is usual: {done}; no alarm yet", values)
        last = self.last
        values |= {
            f"alarm above {joint}": f"{one:.3g} times its usual error"
            for joint, one in zip(self._joints, self.threshold, strict=True)
        }
        if last is None:
            return Status(Level.OK, "no touch so far", values)
        values |= {"last touch [s]": f"{last.at / 1e9:.3f}", "last touched": last.joint}
        if abs(self._now - last.noticed) > SHOWN * 1e9:
            return Status(Level.OK, f"no touch for {abs(self._now - last.at) / 1e9:.0f} s", values)
        return Status(
            Level.WARN,
            f"touched at {last.at / 1e9:.3f} s: {last.joint} gives {last.torque:+.3g} N·m beyond "
            f"what the motion takes, {last.strength:.0f} times its usual error",
            values,
        )

    def forget(self) -> None:
        """Drop the last states: nothing came for too long."""
        self._segment = -1

    def _learn(self, at: int, z: Floats, inside: Flags) -> None:
        """Take the largest output of each second and joint, a touch as no more than the threshold.

        Args:
            at: ns.  z: (N,) over what is expected.  inside: (N,) whether it counts.
        """
        number = at // round(BLOCK * 1e9)
        if number != self._block:
            if self._block >= 0 and self._largest.any():
                self._blocks.append(np.minimum(self._largest, self.threshold))
                if len(self._blocks) >= LEARNING:
                    seen = np.array(self._blocks)
                    # With enough of them, the live ones alone say what is usual.
                    if len(seen) < ENOUGH and len(self._errors.blocks):
                        seen = np.concatenate([self._errors.blocks, seen])
                    self.threshold = once_in(HOUR * len(self._joints), seen)
            self._block, self._largest = number, np.zeros(len(self._joints))
        self._largest = np.maximum(self._largest, np.where(inside, z, 0.0))
