"""What samples say to a model on landmarks, summed: all that is kept of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import blas

from lagrangian_ff.identification.solving.landmarks import Landmarks
from lagrangian_ff.identification.solving.rows import Rows
from lagrangian_ff.progress import Progress, silent

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Sums:
    """What a group of samples says.

    Attributes:
        products: (K, K) [Ψ Φ y]ᵀ D⁻¹ [Ψ Φ y], K = M + B + 1; only the lower triangle is written.
        count: torques.  log_noise: log |D|.
    """

    products: Floats
    count: int
    log_noise: float

    @classmethod
    def over(
        cls, landmarks: Landmarks, rows: Rows, samples: Ints, progress: Progress = silent
    ) -> "Sums":
        """The sum over some samples, chunk by chunk."""
        size = landmarks.size + rows.columns.shape[1] + 1
        products = np.zeros((size, size), order="F")
        log_noise, done = 0.0, 0
        for chunk in landmarks.chunks(samples):
            at = rows.of(chunk)
            features = landmarks.features(rows.states.take(chunk))
            held = np.column_stack([features, rows.design(chunk), rows.target[at]])
            held /= np.sqrt(rows.noise[at])[:, None]
            # Accumulated in place, half of the work of a product.
            products = blas.dsyrk(1.0, held.T, beta=1.0, c=products, lower=1, overwrite_c=1)
            log_noise += float(np.sum(np.log(rows.noise[at])))
            done += len(chunk)
            progress(done / len(samples), "summing over the samples")
        return cls(products, len(samples) * len(landmarks.joints), log_noise)

    def plus(self, other: "Sums", sign: float = 1.0) -> "Sums":
        """With another group as well, or without it."""
        return Sums(
            self.products + sign * other.products,
            self.count + int(sign) * other.count,
            self.log_noise + sign * other.log_noise,
        )

    def squares_left(self, theta: Floats) -> float:
        """The squares of y − Ψ w − Φ b over the noise, for theta (K,) = (−w, −b, 1)."""
        return float(theta @ blas.dsymv(1.0, self.products, theta, lower=1))
