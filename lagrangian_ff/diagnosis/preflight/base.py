"""The case that the checks look at, and their findings."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.lag import delay_option
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.predicting import by_part
from lagrangian_ff.kernels import States
from lagrangian_ff.recording.motion import Conditioning, Motion
from lagrangian_ff.sampling import recorded_seconds, usual_step

THIN = 100.0
"""Hz, at which the model predicts: it knows nothing faster than its filter lets through."""
MARGIN = 0.05
"""Share of a model's range by which a state may lie outside and still count as known."""
ENOUGH = 5.0
"""s inside that range that a comparison of torques takes."""
CLEAR = 0.85
"""Least correlation of measured and predicted torque for a comparison of the two."""
SIGN = "effort sign"
"""The name of the checks that look for an effort of the other sign."""
_STILL = 1e-9  # N·m, a torque that does not change


@dataclass(frozen=True)
class Remedy:
    """A setting of reading that undoes a fault.

    Attributes:
        words: what it does, as a button says it.
        effort_scale: by joint, N·m per unit of effort, in place of what was used.
        effort: what the effort holds, one of `EFFORTS`; empty to leave that.
        effort_delay: s by which all effort comes late; None to leave that.
    """

    words: str
    effort_scale: Mapping[str, float] = field(default_factory=dict)
    effort: str = ""
    effort_delay: float | None = None

    @property
    def option(self) -> str:
        """Return it as the command line has it."""
        if self.effort_delay is not None:
            return delay_option(self.effort_delay)
        scales = " ".join(f"{joint}={factor:.4g}" for joint, factor in self.effort_scale.items())
        return f"--effort {self.effort}" if self.effort else f"--effort-scale {scales}"

    def applied(self, conditioning: Conditioning) -> Conditioning:
        """Return settings of reading with it."""
        delay = self.effort_delay
        return replace(
            conditioning,
            effort_scale={**conditioning.effort_scale, **self.effort_scale},
            effort=self.effort or conditioning.effort,
            effort_delay=conditioning.effort_delay if delay is None else delay,
        )


def scaling(motion: Motion, factors: Mapping[str, float], words: str) -> Remedy:
    """Return the remedy that multiplies the effort of some joints by further factors.

    Args:
        motion: knows with which scale it was read.
    """
    given = motion.conditioning.get("effort_scale")
    known = given if isinstance(given, dict) else {}
    # As many digits as the option shows, so that both do the same.
    scale = {joint: float(f"{known.get(joint, 1.0) * f:.4g}") for joint, f in factors.items()}
    return Remedy(words, scale)


def turned_round(motion: Motion, joints: Sequence[str]) -> Remedy:
    """Return the remedy that turns the sign of some joints' effort round."""
    every = len(joints) == len(motion.joints) > 1
    whose = "every sign" if every else f"the sign of {', '.join(joints)}"
    return scaling(motion, dict.fromkeys(joints, -1.0), f"Turn {whose} round")


@dataclass(frozen=True)
class Check:
    """A finding of one check.

    Attributes:
        check: its name.  joint: the one it concerns; None for all.
        finding: a sentence for people.
        serious: whether it must be mended before any effect is believed.
        advice: what to do; empty for nothing.
        values: the numbers behind it, by name; s, rad, N·m.
        source: the recording, if it is one of several.
        remedy: the setting of reading that the advice names; None if it names none.
    """

    check: str
    joint: str | None
    finding: str
    serious: bool = False
    advice: str = ""
    values: Mapping[str, float] = field(default_factory=dict)
    source: str = ""
    remedy: Remedy | None = None


@dataclass(frozen=True)
class Case:
    """A model and a measured motion, side by side.

    Attributes:
        model: the model.  motion: the recording, its joints in the model's order.
        others: further recordings, likewise.  thin: the motion at about `THIN`.
        predicted: (M, N) N·m at the samples of `thin`.
        correlation: (N,) of measured and predicted torque, inside the model's range; 0 if that is
            less than `ENOUGH` seconds.
        slope: (N,) measured per predicted torque, with its sign: the ratio of their spreads.
        known: (M,) whether a sample of `thin` lies inside the model's range.
    """

    model: Model
    motion: Motion
    others: tuple[Motion, ...]
    thin: Motion
    predicted: Floats
    correlation: Floats
    slope: Floats
    known: NDArray[np.bool_]

    @classmethod
    def of(cls, model: Model, motion: Motion, others: Sequence[Motion] = ()) -> "Case":
        """Return the case, with the predictions of the model.

        Raises:
            ModelError: a recording lacks a joint of the model; names both lists.
        """
        motion, *rest = (_of_model(model, one) for one in (motion, *others))
        thin = thinned(motion)
        predicted = model.predict(thin.q, thin.qd, thin.qdd, time=thin.time, segment=thin.segment)
        excess = model.range.excess(States.of(thin.q, thin.qd, thin.qdd))
        known = np.asarray((excess <= MARGIN).all(axis=1))
        if known.sum() < ENOUGH * THIN:
            nothing = np.zeros(len(model.joints))
            return cls(model, motion, tuple(rest), thin, predicted, nothing, nothing + 1.0, known)
        measured = thin.tau[known] - thin.tau[known].mean(axis=0)
        expected = predicted[known] - predicted[known].mean(axis=0)
        size = np.sqrt((measured**2).mean(axis=0)), np.sqrt((expected**2).mean(axis=0))
        turns = (size[0] > _STILL) & (size[1] > _STILL)
        correlation, slope = np.zeros(len(turns)), np.ones(len(turns))
        common = (measured * expected).mean(axis=0)
        correlation[turns] = common[turns] / (size[0] * size[1])[turns]
        slope[turns] = np.copysign(size[0][turns] / size[1][turns], common[turns])
        return cls(model, motion, tuple(rest), thin, predicted, correlation, slope, known)

    @property
    def joints(self) -> tuple[str, ...]:
        """Return the names of the model's joints."""
        return self.model.joints

    @property
    def clear(self) -> NDArray[np.bool_]:
        """Return whether measured torque follows the model closely enough to compare them, (N,)."""
        return np.abs(self.correlation) >= CLEAR

    @cached_property
    def parts(self) -> dict[str, Floats]:
        """Return the model's torque at `thin` by `PARTS` of effects, (M, N) N·m each."""
        x = self.thin
        return by_part(self.model.terms(x.q, x.qd, x.qdd, time=x.time, segment=x.segment))

    @property
    def residual(self) -> Floats:
        """Return measured less predicted torque at `thin`, (M, N) N·m."""
        return self.thin.tau - self.predicted


def rate_of(motion: Motion) -> float:
    """Return the sample rate in Hz; 0 if it is not known."""
    step = usual_step(motion.time, motion.segment)
    return 1.0 / step if step else 0.0


def thinned(motion: Motion, rate: float = THIN) -> Motion:
    """Return the motion at about `rate` Hz, by leaving samples out."""
    return motion.take(slice(None, None, max(1, round(rate_of(motion) / rate))))


def duration_of(motion: Motion) -> float:
    """Return the time that was measured in s, gaps left out."""
    return recorded_seconds(motion.time, motion.segment)


def _of_model(model: Model, motion: Motion) -> Motion:
    model.require_motion(motion)
    return _on_one_clock(motion.select(model.joints))


def _on_one_clock(motion: Motion) -> Motion:
    """Return the motion with later segments later: several recordings may each begin at 0."""
    step = np.diff(motion.time)
    back = np.flatnonzero(step <= 0.0)
    if not back.size:
        return motion
    shift = np.zeros(len(motion))
    for k in back.tolist():
        shift[k + 1 :] += 1.0 / rate_of(motion) - step[k]
    return replace(motion, time=motion.time + shift)
