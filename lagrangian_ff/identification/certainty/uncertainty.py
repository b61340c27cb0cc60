"""The predictive variance of torques, and intervals made from it.

The factor of the training Gram matrix gives the variance of a torque,

    s² (k(x, x) − k_xᵀ G⁻¹ k_x + (φ_x − Φᵀ G⁻¹ k_x)ᵀ (Φᵀ G⁻¹ Φ)⁻¹ (φ_x − Φᵀ G⁻¹ k_x)) + noise:

what the data leave of the kernel's prior, and the uncertainty of the effects' parameters (Rasmussen
and Williams 2006, Gaussian Processes for Machine Learning, eq. (2.42)). It assumes
white noise. The errors of real arms are not white, so that one factor a joint scales the deviations
to the residuals of blocks left out. Models on inducing points have a variance of the same meaning,
see `low_rank`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.blueprint import Blueprint, solve
from lagrangian_ff.identification.certainty.calibration import (
    LEVEL,
    QUICK,
    SubsetOfData,
    calibrated,
)
from lagrangian_ff.identification.predicting import TorqueModel
from lagrangian_ff.identification.records import Calibration
from lagrangian_ff.identification.solving.posterior import Posterior, Variance
from lagrangian_ff.identification.solving.robust import heavy_tailed
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.record_json import read

CHUNK_ENTRIES = 4_000_000
"""Kernel values held at once: 32 MB."""


@dataclass(frozen=True)
class Uncertainty:
    """Variance and intervals of predicted torques, and the share that the data leave unknown.

    Arguments q, qd, qdd (M, N), or (N,) for one state, time, segment and progress are those of
    `Model.predict`. Results are (M, N), or (N,) for one state.

    Attributes:
        model: of the torques.
        factor: (N,) on standard deviations, calibrated on blocks left out.
        posterior: of the model.
    """

    model: TorqueModel
    factor: Floats
    posterior: Posterior = field(repr=False)

    @classmethod
    def of(cls, model: TorqueModel) -> "Uncertainty":
        """Return the uncertainty of a model, solved again from the data that it keeps."""
        made = Blueprint.of(model)
        solved = solve(made, _data(model))
        residual = solved.weighed.left_out(made.apart)
        return cls(model, calibrated(made, solved, residual), solved.weighed)

    @classmethod
    def quick(cls, model: TorqueModel) -> "Uncertainty":
        """Return the cheap form of `QUICK` samples, whose calibration is in the record.

        A record without a calibration, of an older version, needs the whole system solved first.
        """
        kept = quick_factor(model)
        if kept is None:
            return cls.of(model).thinned(QUICK)
        made = Blueprint.of(model)
        ones = np.ones((len(made.seen), len(model.joints)))
        weight = ones if made.weight is None else heavy_tailed(made.weight)
        subset = SubsetOfData(made, _data(model).take(made.seen), weight, QUICK)
        try:
            return cls(model, kept, subset.fit())
        except NotPositiveDefiniteError as error:
            raise ModelError(f"how sure the model is cannot be computed: {error}") from error

    def thinned(self, samples: int) -> "Uncertainty":
        """Return a cheap form, from fewer samples, for one state at a time in a loop.

        Its variance is never smaller, but for the calibration, which is repeated on all
        samples. The time of one state falls with the square of the number of samples.

        Args:
            samples: number to keep, evenly spread.

        Raises:
            ModelError: fewer than 10.
        """
        if samples < 10:
            raise ModelError(f"samples is {samples}, expected at least 10")
        made = Blueprint.of(self.model)
        weight = self.posterior.problem.samples.weights
        subset = SubsetOfData(made, _data(self.model).take(made.seen), weight, samples)
        residual = self.posterior.left_out(made.apart)
        return replace(self, factor=subset.factor(residual), posterior=subset.fit())

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
        """Return the variance in (N·m)² of the torques that would be measured.

        Args:
            noise: whether the noise of a measurement is included.
            at: (A,) samples to return; the others only give the past to effects that remember.
        """
        x = _inputs(self.model, q, qd, qdd, time, segment)
        parts = [
            found.whole if noise else found.kernel + found.basis
            for found in self._found(x if at is None else x.take(at), progress)
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
        """Return the ends in N·m of the interval that holds a share of the measured torques.

        Calibrated at 90 %; other levels take the errors to be normal.

        Args:
            level: the share, above 0 and below 1.

        Raises:
            ModelError: the level is no share.
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
        """Return half the width of the interval, in N·m; see `interval`.

        Arguments `level` and `at` are those of `interval` and `variance`.
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
        """Return the share, 0 to 1, of the variance that more data here would take away.

        Near 0 all variance is noise, the model knows the torque; near 1 it guesses. Unlike
        `MotionRange.excess`, which compares each joint with its range, this counts combinations of
        joints as the kernel does: `chain` carries over to postures not seen.
        """
        found = self._found(_inputs(self.model, q, qd, qdd, time, segment), progress)
        whole = np.concatenate([(v.kernel + v.basis) / v.whole for v in found])
        return whole if np.ndim(q) > 1 else whole[0]

    def _found(self, x: Inputs, progress: Progress) -> Iterator[Variance]:
        """Yield the variance in parts, chunk by chunk, so that memory stays bounded."""
        chunk = max(1, CHUNK_ENTRIES // (x.joints**2 * max(1, len(self.posterior.states))))
        for first in range(0, len(x), chunk):
            yield self.posterior.variance(x.take(np.arange(first, min(first + chunk, len(x)))))
            progress(min(1.0, (first + chunk) / len(x)), "measuring certainty")


def quick_factor(model: TorqueModel) -> Floats | None:
    """Return (N,) the calibration of `Uncertainty.quick` in the record; None if it has none."""
    kept = model.record.get("uncertainty")
    quick = read(Calibration, kept).quick if isinstance(kept, Mapping) else None
    if quick is None or tuple(quick) != model.joints:
        return None
    return np.array(list(quick.values()), dtype=np.float64)


def _data(model: TorqueModel) -> Inputs:
    """Return all of the data that the model keeps, as effects see it."""
    data = model.data
    motion = data.q, data.qd, data.qdd, data.time, data.segment
    return _inputs(model, *motion, data.temperature)


def _inputs(
    model: TorqueModel,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    time: ArrayLike | None,
    segment: Ints | None,
    temperature: Floats | None = None,
) -> Inputs:
    """Return a motion as effects see it, with torques (slow) only if an effect uses them."""
    if not any(term.effect.uses for term in model.basis.terms):
        speed = model.basis.sign_speed(len(model.joints))
        x = model.states(q, qd, qdd)
        return Inputs.of(x, time, segment, None, None, speed, temperature)
    inputs = model.inputs(q, qd, qdd, time=time, segment=segment, temperature=temperature)
    return model.with_torque(inputs)
