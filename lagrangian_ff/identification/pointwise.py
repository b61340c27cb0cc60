"""The torque of one state after the other, as a control loop asks for it: nothing is looked up."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lagrangian_ff.effects import Effect, Inputs
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.model import Model
from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]


class Pointwise:
    """A model at one state at a time; for one thread.

    Effects that allow it are done for all joints at once, the others one by one as in
    `Model.predict`, which gives the same torques.

    Args:
        model: whose torque is asked for.
    """

    def __init__(self, model: Model) -> None:
        self.joints = model.joints
        count = len(model.joints)
        self._states = States(*np.zeros((3, 1, count)))
        self._learned = model.learned
        self._unit = model.unit
        x = self._states
        self._across = Inputs.of(States(x.q.T, x.qd.T, x.qdd.T))
        placed = [(term, model.coefficients[place]) for term, place in model.basis.slices()]
        # What follows the torque must see that of every other effect.
        apart = any("torque" in term.effect.uses for term, _ in placed)
        fast = [(t, value) for t, value in placed if t.effect.side_by_side and not apart]
        slow = [(t, value) for t, value in placed if not t.effect.side_by_side or apart]
        self._together = list(_together(fast, count))
        self._columns = np.empty((count, sum(group.width for group in self._together)))
        self._fast = np.concatenate(
            [np.zeros((count, 0)), *(group.coefficients for group in self._together)], axis=1
        )
        self._rest = Basis(tuple(term for term, _ in slow))
        self._coefficients = np.concatenate([np.zeros(0), *(value for _, value in slow)])
        self._speed = model.basis.sign_speed(count)
        self._constant = model.basis.constant(count, model.coefficients)

    def torque(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Floats:
        """(N,) N·m at a state of q (N,) rad, qd (N,) rad/s and qdd (N,) rad/s².

        Raises:
            ValueError: an array is not of this many joints.
        """
        x = self._states
        x.q[0], x.qd[0], x.qdd[0] = q, qd, qdd
        rigid = self._learned.torque(x)[0] * self._unit
        first = 0
        for group in self._together:
            last = first + group.width
            self._columns[:, first:last] = group.columns(self._across)
            first = last
        torque = rigid + np.einsum("np,np->n", self._columns, self._fast)
        if self._rest.terms:
            torque += self._others(x, rigid + self._constant)
        return torque

    def _others(self, x: States, load: Floats) -> Floats:
        inputs = Inputs.of(x, None, None, load[None], load[None], self._speed)
        parts = self._rest.torque(inputs, self._coefficients)
        return np.asarray(sum(parts.values(), np.zeros_like(x.q))[0])


@dataclass(frozen=True)
class _Together:
    """One effect on many joints at once.

    Attributes:
        effect: which.  shape: its nonlinear parameters, (N, 1) each.
        coefficients: (N, P), zero where a joint does not have it.
    """

    effect: Effect
    shape: dict[str, Floats]
    coefficients: Floats

    @property
    def width(self) -> int:
        """P, how many parameters the effect has on a joint."""
        return self.coefficients.shape[1]

    def columns(self, x: Inputs) -> Floats:
        """(N, P) what the parameters multiply, of joints that stand in for samples."""
        return self.effect.columns(x, 0, self.shape)  # type: ignore[arg-type]


def _together(terms: Iterable[tuple[Term, Floats]], joints: int) -> Iterable[_Together]:
    by_effect: dict[str, list[tuple[Term, Floats]]] = {}
    for term, value in terms:
        by_effect.setdefault(term.effect.name, []).append((term, value))
    for several in by_effect.values():
        effect = several[0][0].effect
        shape = {one.name: np.full((joints, 1), one.start) for one in effect.shapes}
        coefficients = np.zeros((joints, len(effect.parameters)))
        for term, value in several:
            coefficients[term.joint] += value
            for name, number in term.shape.items():
                shape[name][term.joint] = number
        yield _Together(effect, shape, coefficients)
