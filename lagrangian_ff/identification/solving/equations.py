"""Solving the semi-parametric model (44) with every hyperparameter given."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.choice import Choice, Scaling
from lagrangian_ff.identification.solving.fit import Fit
from lagrangian_ff.identification.solving.rows import Rows
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.identification.spec import Spec
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.dense import gram_of, together
from lagrangian_ff.progress import Progress, silent

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Equations:
    """Problem (44) with all but the trust in each torque given: solved for one trust or several.

    Attributes:
        choice: the hyperparameters.  scaling: of the torques.  basis: the effects' terms.
        states: (M, N) the training states.
        parts: which joints are solved together, their basis, Gram matrix, and what they learn from.
    """

    choice: Choice
    scaling: Scaling
    basis: Basis
    states: States
    parts: tuple[tuple[tuple[int, ...], Basis, Floats, Rows], ...]

    @classmethod
    def of(
        cls,
        basis: Basis,
        choice: Choice,
        x: Inputs,
        tau: Floats,
        scaling: Scaling,
        only: int | None = None,
    ) -> "Equations":
        """The equations of a basis whose shapes are given; see `fit`."""
        states = States(x.q, x.qd, x.qdd)
        parts = []
        for joints in together(choice.kernel, states.joints):
            if only is not None and only not in joints:
                continue
            part, rows = rows_to_learn(basis, choice, x, tau, scaling, joints)
            parts.append((joints, part, gram_of(choice.kernel, states, joints), rows))
        return cls(choice, scaling, basis, states, tuple(parts))

    def solve(
        self, trust: Floats | None = None, *, last: bool = True, progress: Progress = silent
    ) -> Fit[System]:
        """Factor and solve them.

        Args:
            trust: (M, N) of each torque; None trusts all.
            last: the Gram matrices are overwritten, so that nothing can be solved again.
            progress: told the share done.

        Raises:
            NotPositiveDefiniteError: the noise is too small for the arithmetic.
        """
        trust = np.ones_like(self.states.q) if trust is None else trust
        systems = []
        for number, (joints, part, gram, rows) in enumerate(self.parts):
            own, known = (gram if last else gram.copy()), rows.trusted(trust[:, list(joints)])
            factored = System.factor(own, known.noise, known.design(), known.target)
            systems.append((joints, part, factored))
            progress((number + 1) / len(self.parts), "fitting")
        count = len(self.states)
        return Fit(self.choice, self.scaling, self.basis, self.states, count, tuple(systems), trust)


def fit(
    spec: Spec,
    choice: Choice,
    x: States | Inputs,
    tau: Floats,
    scaling: Scaling,
    trust: Floats | None = None,
    only: int | None = None,
) -> Fit[System]:
    """Solve (44) for given hyperparameters: one Cholesky factor a system.

    Args:
        spec: the kernel's family and the effects.
        choice: hyperparameters and shapes.
        x: (M, N) training states, as inputs where an effect needs more than the state.
        tau: (M, N) N·m.
        scaling: how torques are normalised.
        trust: (M, N) of each torque; None trusts all.
        only: the joint that is asked for, where joints are learned apart; None is all.

    Raises:
        NotPositiveDefiniteError: the noise is too small for the arithmetic.
    """
    inputs = x if isinstance(x, Inputs) else Inputs.of(x)
    basis = choice.basis(spec, inputs.joints)
    return Equations.of(basis, choice, inputs, tau, scaling, only).solve(trust)


def fit_basis(
    basis: Basis,
    choice: Choice,
    x: Inputs,
    tau: Floats,
    scaling: Scaling,
    trust: Floats | None = None,
) -> Fit[System]:
    """Solve (44) for a basis whose shapes are given; see `fit`.

    Raises:
        NotPositiveDefiniteError: the noise is too small for the arithmetic.
    """
    return Equations.of(basis, choice, x, tau, scaling).solve(trust)


def rebased(fitted: Fit[System], basis: Basis, x: Inputs, tau: Floats) -> Fit[System]:
    """The same with other shapes of the effects, which the Gram matrix does not know of.

    Args:
        fitted: all but the basis.
        basis: of the same joints.
        x, tau: what it was fitted to.
    """
    choice = fitted.choice.shaped_as(basis)
    systems = []
    for joints, _, system in fitted.systems:
        part, rows = rows_to_learn(basis, choice, x, tau, fitted.scaling, joints)
        systems.append((joints, part, system.of(rows.design(), rows.target)))
    return replace(fitted, choice=choice, basis=basis, systems=tuple(systems))


def rows_to_learn(
    basis: Basis, choice: Choice, x: Inputs, tau: Floats, scaling: Scaling, joints: tuple[int, ...]
) -> tuple[Basis, Rows]:
    """The basis of some joints, and what a system of them learns from, normalised."""
    part, rows = basis.of_joints(joints), list(joints)
    noise = choice.noise * scaling.noise**2
    return part, Rows(
        States(x.q, x.qd, x.qdd),
        part.columns(x) / scaling.unit[part.joints],
        np.array([joints.index(joint) for joint in part.joints], dtype=np.int64),
        (tau[:, rows] / scaling.unit[rows]).ravel(),
        np.tile(noise[rows], len(x)),
    )
