"""What the joints that are solved together learn from, in the order of their system."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Rows:
    """S samples of n joints: S n rows, sample major.

    Attributes:
        states: (S, N), of all joints.
        columns: (S, B) the basis, each column of the torque of one joint.
        joint: (B,) whose it is, among the n.
        target: (S n,) the torques y.
        noise: (S n,) variance of each torque.
    """

    states: States
    columns: Floats
    joint: Ints
    target: Floats
    noise: Floats

    def trusted(self, trust: Floats) -> "Rows":
        """These with the noise of each torque 1 / trust (S, n) times as large."""
        return replace(self, noise=self.noise / trust.ravel())

    def of(self, samples: Ints) -> Ints:
        """(R n,) the rows of these samples."""
        return rows_of(samples, len(self.target) // len(self.states))

    def design(self, samples: "Ints | slice" = slice(None)) -> Floats:
        """(R n, B) the rows of Φ of these samples: zero but for each column's own joint."""
        columns = self.columns[samples]
        width = len(self.target) // len(self.states)
        out = np.zeros((len(columns), width, columns.shape[1]))
        out[:, self.joint, np.arange(columns.shape[1])] = columns
        return out.reshape(len(columns) * width, columns.shape[1])


def rows_of(samples: Ints, width: int) -> Ints:
    """(R n,) the rows of some samples in a system of n joints."""
    return np.asarray((samples[:, None] * width + np.arange(width)).ravel(), dtype=np.int64)
