"""How sure a model is of the torques it predicts.

The factor of the training Gram matrix gives the variance of a torque,

    s² (k(x, x) − k_xᵀ G⁻¹ k_x + (φ_x − Φᵀ G⁻¹ k_x)ᵀ (Φᵀ G⁻¹ Φ)⁻¹ (φ_x − Φᵀ G⁻¹ k_x)) + noise:

what the data leave of the kernel's prior, and the uncertainty of the effects' parameters (Rasmussen
and Williams 2006, Gaussian Processes for Machine Learning, eq. (2.42)). It believes errors to be
white noise. On real arms they are not, so that a factor a joint makes the deviations as large as
the residuals of blocks left out ask for. Models on landmarks have a variance of the same meaning,
see `low_rank`.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.blueprint import Blueprint
from lagrangian_ff.identification.certainty.calibration import calibrated
from lagrangian_ff.identification.certainty.few import QUICK, Few
from lagrangian_ff.identification.certainty.intervals import LEVEL
from lagrangian_ff.identification.model import Model
from lagrangian_ff.identification.solve import solve
from lagrangian_ff.identification.solving.fit import Fit, Variance
from lagrangian_ff.identification.solving.robust import doubted
from lagrangian_ff.progress import Progress, silent

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CHUNK_ENTRIES = 4_000_000
"""Kernel values held at once: 32 MB."""


@dataclass(frozen=True)
class Uncertainty:
    """Variance, intervals, and how much of a torque the data say nothing about.

    Arguments are (M, N), or (N,) for one state, as those of `Model.predict`.

    Attributes:
        model: whose torques.
        factor: (N,) what standard deviations are multiplied with to hold what was left out.
        fitted: the solved system.
    """

    model: Model
    factor: Floats
    fitted: Fit = field(repr=False)

    @classmethod
    def of(cls, model: Model) -> "Uncertainty":
        """Solve a model's system again from the data that it keeps."""
        made = Blueprint.of(model)
        solved = solve(made, _data(model))
        met, _ = solved.weighed.left_out(made.apart)
        return cls(model, calibrated(made, solved, met), solved.weighed)

    @classmethod
    def quick(cls, model: Model) -> "Uncertainty":
        """The cheap form of `QUICK` samples, ready in an instant: its calibration is in the record.

        The record of models identified before it was kept has none; of them it is `thinned`, which
        solves the whole system first.
        """
        kept = quick_factor(model)
        if kept is None:
            return cls.of(model).thinned(QUICK)
        made = Blueprint.of(model)
        trust = np.ones_like(model.training_tau) if made.trust is None else doubted(made.trust)
        few = Few(made, _data(model).take(made.seen), trust, QUICK)
        return cls(model, kept, few.fit())

    def thinned(self, samples: int) -> "Uncertainty":
        """A cheap form, from fewer of the samples: for one state at a time in a loop.

        It knows less and is never surer, but for its calibration, which is made anew on all
        samples. The time of one state falls with the square of the number of samples.

        Args:
            samples: how many to keep, evenly spread.

        Raises:
            ModelError: fewer than 10.
        """
        if samples < 10:
            raise ModelError(f"samples is {samples}, expected at least 10")
        made = Blueprint.of(self.model)
        few = Few(made, _data(self.model).take(made.seen), self.fitted.trust, samples)
        met, _ = self.fitted.left_out(made.apart)
        return replace(self, factor=few.factor(met), fitted=few.fit())

    def variance(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        progress: Progress = silent,
        *,
        time: ArrayLike | None = None,
        segment: Ints | None = None,
        noise: bool = True,
        at: Ints | None = None,
    ) -> Floats:
        """Variance in (N·m)² of the torques that would be measured.

        Args:
            q, qd, qdd, time, segment: see `Model.predict`.
            progress: told the share done.
            noise: without it, of the torque itself, as far as the model can tell the two apart.
            at: (A,) which of the samples are asked for; the others only tell the past to effects
                that remember. Without it, all.

        Returns:
            (M, N) or (A, N), or (N,) for one state.

        Raises:
            ModelError: the arrays are not of this model's joints.
        """
        parts = [
            found.whole if noise else found.kernel + found.basis
            for found in self._found(q, qd, qdd, progress, time, segment, at)
        ]
        whole = np.concatenate(parts) * self.factor**2
        return whole if np.ndim(q) > 1 else whole[0]

    def interval(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        level: float = LEVEL,
        progress: Progress = silent,
        *,
        time: ArrayLike | None = None,
        segment: Ints | None = None,
    ) -> tuple[Floats, Floats]:
        """The interval that holds a share of the torques that would be measured.

        Calibrated at 90 %; other levels take the errors to be normal.

        Args:
            q, qd, qdd, time, segment: see `Model.predict`.
            level: the share, above 0 and below 1.
            progress: told the share done.

        Returns:
            Lower and upper ends in N·m, (M, N) each, or (N,) for one state.

        Raises:
            ModelError: the level is no share, or the arrays are not of this model's joints.
        """
        reach = self.reach(q, qd, qdd, level, progress, time=time, segment=segment)
        middle = self.model.predict(q, qd, qdd, time=time, segment=segment)
        return middle - reach, middle + reach

    def reach(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        level: float = LEVEL,
        progress: Progress = silent,
        *,
        time: ArrayLike | None = None,
        segment: Ints | None = None,
        at: Ints | None = None,
    ) -> Floats:
        """How far the interval reaches to both sides of the prediction, in N·m; see `interval`.

        Args:
            q, qd, qdd, time, segment: see `Model.predict`.
            level: see `interval`.
            progress: told the share done.
            at: see `variance`.

        Returns:
            (M, N) or (A, N), or (N,) for one state.

        Raises:
            ModelError: the level is no share, or the arrays are not of this model's joints.
        """
        if not 0.0 < level < 1.0:
            raise ModelError(f"level is {level}, expected above 0 and below 1, as in 0.9")
        variance = self.variance(q, qd, qdd, progress, time=time, segment=segment, at=at)
        return np.asarray(NormalDist().inv_cdf(0.5 + level / 2.0) * np.sqrt(variance))

    def unknown(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        progress: Progress = silent,
        *,
        time: ArrayLike | None = None,
        segment: Ints | None = None,
    ) -> Floats:
        """How far from the data: the share of the variance that more data here would take away.

        Near 0 all there is is noise, the model knows the torque; near 1 it guesses. Other than
        `MotionRange.excess`, which compares joint by joint with the box of what was seen, it knows
        combinations, and what the kernel makes of them: `chain` carries over to postures not seen.

        Args:
            q, qd, qdd, time, segment: see `Model.predict`.
            progress: told the share done.

        Returns:
            (M, N) from 0 to 1, or (N,) for one state.

        Raises:
            ModelError: the arrays are not of this model's joints.
        """
        found = self._found(q, qd, qdd, progress, time, segment)
        whole = np.concatenate([(v.kernel + v.basis) / v.whole for v in found])
        return whole if np.ndim(q) > 1 else whole[0]

    def _found(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        progress: Progress,
        time: ArrayLike | None,
        segment: Ints | None,
        at: Ints | None = None,
    ) -> Iterator[Variance]:
        """The variance in parts, chunk by chunk, so that memory stays bounded."""
        x = _inputs(self.model, q, qd, qdd, time, segment)
        x = x if at is None else x.take(at)
        chunk = max(1, CHUNK_ENTRIES // (x.joints**2 * max(1, len(self.fitted.states))))
        for first in range(0, len(x), chunk):
            yield self.fitted.variance(x.take(np.arange(first, min(first + chunk, len(x)))))
            progress(min(1.0, (first + chunk) / len(x)), "measuring certainty")


def quick_factor(model: Model) -> Floats | None:
    """(N,) the calibration of `Uncertainty.quick` that the record keeps; None where it has none."""
    kept = model.record.get("uncertainty")
    quick = kept.get("quick") if isinstance(kept, dict) else None
    if not isinstance(quick, dict) or list(quick) != list(model.joints):
        return None
    return np.array(list(quick.values()), dtype=np.float64)


def _data(model: Model) -> Inputs:
    """All of the data that it keeps."""
    data = model.data
    return _inputs(model, data.q, data.qd, data.qdd, data.time, data.segment)


def _inputs(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    time: ArrayLike | None,
    segment: Ints | None,
) -> Inputs:
    """A motion as effects see it; torques, which take time, only where one of them looks at it."""
    if not any(term.effect.uses for term in model.basis.terms):
        speed = model.basis.sign_speed(len(model.joints))
        return Inputs.of(model.states(q, qd, qdd), time, segment, sign_speed=speed)
    x = model.inputs(q, qd, qdd, time=time, segment=segment)
    return replace(x, torque=x.load + model.basis.beside_load(x, model.coefficients))
