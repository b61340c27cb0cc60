"""The state of a model: its residual and its intervals compared with when it was identified."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Flags, Floats
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.certainty.uncertainty import quick_factor
from lagrangian_ff.identification.predicting import MotionRange
from lagrangian_ff.identification.records import Score
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.streaming.ranges import excess
from lagrangian_ff.nodes.watching.live import Judged

FEWEST = 20
"""States of a joint below which it is not judged."""
FLOOR = 1e-3
"""Share of the largest torque identified: the smallest error to expect."""
AWAY = 0.2
"""Share of the time outside the identified range that is worth a warning."""
PAUSE = 0.1
"""s between the states of `Coverage`: one takes 1 ms, and neighbours err alike."""


@dataclass(frozen=True)
class Limits:
    """The rules for judging and warning.

    Attributes:
        window: s looked back on.
        still: rad/s; a slower joint may be held by its friction at any torque, it is not judged.
        margin: how far outside still counts as inside, as a fraction of the identified range.
        warn, error: times the error when identified.
    """

    window: float
    still: float
    margin: float
    warn: float
    error: float


class Coverage:
    """The share of the last seconds' torques outside the model's 90 % intervals.

    One in ten should be. Joints that hardly move do not count: see `Limits.still`.

    Args:
        model: of the states' joints.

    Raises:
        ModelError: the model cannot be calibrated.
    """

    def __init__(self, model: Model) -> None:
        self._joints = model.joints
        self._certain = model.quick_uncertainty
        self._seen: deque[tuple[int, Flags, Flags]] = deque()

    @classmethod
    def of(cls, model: Model) -> "Coverage | None":
        """Return the coverage of a model; None if its file has no calibration, which takes long."""
        return None if quick_factor(model) is None else cls(model)

    def add(self, judged: Judged, limits: Limits) -> None:
        """Take one more instant, unless the last one was just now."""
        state, seen = judged.state, self._seen
        if seen and state.at < seen[-1][0]:
            seen.clear()  # the clock was set back
        if seen and (state.at - seen[-1][0]) / 1e9 < PAUSE:
            return
        outside = np.abs(judged.residual) > self._certain.reach(state.q, state.qd, state.qdd)
        seen.append((state.at, outside, np.abs(state.qd) > limits.still))
        while (state.at - seen[0][0]) / 1e9 > limits.window:
            seen.popleft()

    def forget(self) -> None:
        """Drop what was seen: nothing came for too long."""
        self._seen.clear()

    def values(self) -> dict[str, str]:
        """Return the share by joint, for joints that moved long enough."""
        if not self._seen:
            return {}
        outside, moving = (np.stack([each[k] for each in self._seen]) for k in (1, 2))
        number = moving.sum(axis=0)
        share = (outside & moving).sum(axis=0) / np.maximum(number, 1)
        return {
            f"outside the 90 % interval {joint}": f"{share[n]:.0%}"
            for n, joint in enumerate(self._joints)
            if number[n] >= FEWEST
        }


class Health:
    """The residual of the last seconds against the error the model had on unseen motion.

    Args:
        score: the errors of the model on motion it has not seen; joints may lack.
        known: the identified range.
        coverage: None if the model has no calibration.
    """

    def __init__(
        self,
        joints: tuple[str, ...],
        score: Score,
        known: MotionRange,
        coverage: Coverage | None = None,
    ) -> None:
        expected = np.array([score.by_joint.get(joint, 0.0) for joint in joints])
        self._expected = np.maximum(np.nan_to_num(expected), FLOOR * known.tau_max)  # (N,) N·m
        self._joints, self._known, self._coverage = joints, known, coverage
        self._seen: deque[tuple[int, Floats, Flags, bool]] = deque()

    def add(self, judged: Judged, limits: Limits) -> None:
        """Take one more instant."""
        state = judged.state
        here = state.q[None], state.qd[None], state.qdd[None]
        out = excess(self._joints, np.zeros(1), here, self._known, limits.margin).outside[0]
        counts = (np.abs(state.qd) > limits.still) & ~out
        if self._seen and state.at < self._seen[-1][0]:
            self._seen.clear()  # the clock was set back
        self._seen.append((state.at, judged.residual**2, counts, bool(out)))
        while (state.at - self._seen[0][0]) / 1e9 > limits.window:
            self._seen.popleft()
        if self._coverage is not None:
            self._coverage.add(judged, limits)

    def forget(self) -> None:
        """Drop what was seen: nothing came for too long."""
        self._seen.clear()
        if self._coverage is not None:
            self._coverage.forget()

    def rms(self) -> Floats:
        """Return the residual of the last seconds, (N,) N·m; NaN for joints that hardly moved."""
        if not self._seen:
            return np.full(len(self._joints), np.nan)
        squared, counts = (np.stack([each[k] for each in self._seen]) for k in (1, 2))
        number = counts.sum(axis=0)
        rms = np.sqrt((squared * counts).sum(axis=0) / np.maximum(number, 1))
        return np.where(number >= FEWEST, rms, np.nan)

    def status(self, limits: Limits, more: Mapping[str, object]) -> Status:
        """Return the state over the last seconds, with further values."""
        if self._coverage is not None:
            more = {**more, **self._coverage.values()}
        if not self._seen:
            return Status(Level.STALE, "nothing to compare", more)
        away = float(np.mean([each[3] for each in self._seen]))
        rms = self.rms()
        ratio = rms / self._expected
        values: dict[str, object] = {
            joint: f"{rms[n]:.4g} N·m, {ratio[n]:.2g} times what it was when identified"
            if np.isfinite(ratio[n])
            else "hardly moves: not judged"
            for n, joint in enumerate(self._joints)
        }
        values |= {"outside the identified range": f"{away:.0%}", **more}
        level, message = self._verdict(ratio, away, limits)
        return Status(level, message, values)

    def _verdict(self, ratio: Floats, away: float, limits: Limits) -> tuple[Level, str]:
        judged = np.flatnonzero(np.isfinite(ratio))
        bad = sorted((n for n in judged if ratio[n] > limits.warn), key=lambda n: -ratio[n])
        if bad:
            level = Level.ERROR if ratio[bad[0]] > limits.error else Level.WARN
            return level, "; ".join(
                f"residual of {self._joints[n]} is {ratio[n]:.1f} times what it was when identified"
                for n in bad
            )
        if away > AWAY:
            return Level.WARN, (
                f"{away:.0%} of the last {limits.window:g} s lie outside the range the model was "
                "identified on: not judged"
            )
        if len(judged) == 0:
            return Level.OK, "no joint moves enough to judge the model by"
        worst = judged[int(np.argmax(ratio[judged]))]
        return Level.OK, (
            f"as when identified: at most {ratio[worst]:.1f} times the error of then "
            f"({self._joints[worst]})"
        )
