"""The parameters that a motion was fitted with, while shapes may be wrong or are held.

A motion is whitened with the first-order errors of the shapes as further columns, so that nothing
is found that only makes up for a shape. But an effect in use has one shape, and its parameters
are those that belong to it. Where a shape hardly shows, the difference is large.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.whitening import Whitened
from lagrangian_ff.diagnosis.whitening.errors import TANGENT, errors_of_shapes
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Term


@dataclass(frozen=True)
class Fitted:
    """The fitted parameters of a motion.

    They stand in this order: those of the basis, of the nuisance columns, of the shapes' errors.

    Attributes:
        whitened: the motion.
        values: (C,) the parameters.
        covariance: (C, C) of them.
    """

    whitened: Whitened
    values: Floats
    covariance: Floats

    @classmethod
    def of(cls, whitened: Whitened, variance_inflation: float = 1.0) -> "Fitted":
        """Return what a motion was fitted with, its noise as much larger as is given."""
        system = whitened.system
        scale = variance_inflation * system.amplitude
        return cls(whitened, system.coefficients, scale * system.covariance)

    def holding(self, terms: Sequence[Term]) -> "Fitted":
        """Return the same with the shapes of some terms as they were fitted."""
        # What the motion does not show of a shape has no error to hold.
        own = [n for n in self._errors_of(terms) if self.covariance[n, n] > 0.0]
        if not own:
            return self
        rows = self.covariance[own]
        moves = np.linalg.solve(rows[:, own], rows).T
        values, covariance = self.values - moves @ self.values[own], self.covariance - moves @ rows
        return replace(self, values=values, covariance=covariance)

    def curves(self, joint: int) -> list[tuple[int, Floats]]:
        """Return what is explained on a joint without a name: each place, and its column (S,)."""
        nuisance = self.whitened.problem.nuisance
        columns = [(one.joint, column) for one in nuisance for column in one.columns.T]
        first = self.whitened.basis.size
        return [(first + n, column) for n, (own, column) in enumerate(columns) if own == joint]

    def errors_of_shapes(self, x: Inputs, joint: int) -> list[tuple[int, Term, Floats]]:
        """Return each shape's error on a joint: its place, the term, and its column (M,)."""
        columns = errors_of_shapes(self.whitened.basis, x)
        return [
            (n, term, one.columns[:, 0])
            for (n, term), one in zip(self._errors, columns, strict=True)
            if term.joint == joint
        ]

    def beside(self, terms: Sequence[Term]) -> list[int]:
        """Return the places of the nuisance columns, and of the errors of some terms' shapes."""
        first = len(self.values) - len(self._errors)
        return [*range(self.whitened.basis.size, first), *self._errors_of(terms)]

    def _errors_of(self, terms: Sequence[Term]) -> list[int]:
        """Return the places of the errors of some terms' shapes."""
        names = {(term.effect.name, term.joint) for term in terms}
        return [n for n, term in self._errors if (term.effect.name, term.joint) in names]

    @property
    def _errors(self) -> list[tuple[int, Term]]:
        """Return the place of each shape's error, and the term whose shape it is."""
        tangents = self.whitened.basis.tangents(TANGENT)
        first = len(self.values) - len(tangents)
        return [(first + n, term) for n, (term, _) in enumerate(tangents)]
