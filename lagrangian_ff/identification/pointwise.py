"""The torque of one state after the other, for control loops."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import Effect, Inputs
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.predicting import Terms, TorqueModel
from lagrangian_ff.kernels import States

STAGES = ("at rest", "accelerated", "moving")
"""States whose rigid-body torques give its terms."""


class Pointwise:
    """A model at one state at a time; for one thread.

    Effects that allow it are evaluated for all joints at once, the others one by one as in
    `Model.predict`, which gives the same torques.
    """

    def __init__(self, model: TorqueModel) -> None:
        self.joints = model.joints
        count = len(model.joints)
        self._states = States(*np.zeros((3, 1, count)))
        self._stages = States(*np.zeros((3, len(STAGES), count)))
        self._learned = model.learned
        self._unit = model.unit
        x = self._states
        self._across = Inputs.of(States(x.q.T, x.qd.T, x.qdd.T))
        placed = [(term, model.coefficients[place]) for term, place in model.basis.slices()]
        # An effect that follows the torque needs that of every other effect first.
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
        """Return (N,) N·m at a state of q (N,) rad, qd (N,) rad/s and qdd (N,) rad/s².

        Raises:
            ValueError: an array is not of the model's number of joints.
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
            others = self._by_effect(x, rigid + self._constant).values()
            torque += sum(others, np.zeros_like(x.q))[0]
        return torque

    def terms(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Terms:
        """Return the torque in parts, (N,) N·m each; see `torque` and `Model.terms`.

        Raises:
            ValueError: an array is not of the model's number of joints.
        """
        x, stages = self._states, self._stages
        x.q[0], x.qd[0], x.qdd[0] = q, qd, qdd
        stages.q[:] = x.q
        stages.qd[2], stages.qdd[1:] = x.qd[0], x.qdd[0]
        gravity, lifted, rigid = self._learned.torque(stages) * self._unit
        effects = {
            group.effect.name: np.einsum(
                "np,np->n", group.columns(self._across), group.coefficients
            )
            for group in self._together
        }
        if self._rest.terms:
            for name, torque in self._by_effect(x, rigid + self._constant).items():
                effects[name] = effects.get(name, 0.0) + torque[0]
        return Terms(gravity, lifted - gravity, rigid - lifted, effects)

    def _by_effect(self, x: States, load: Floats) -> dict[str, Floats]:
        """Return (1, N) N·m of each effect that is evaluated alone."""
        inputs = Inputs.of(x, None, None, load[None], load[None], self._speed)
        return self._rest.torque(inputs, self._coefficients)


@dataclass(frozen=True)
class _Together:
    """One effect on many joints at once.

    Attributes:
        effect: with its columns.  shape: its nonlinear parameters, (N, 1) each.
        coefficients: (N, P), zero for joints without it.
    """

    effect: Effect
    shape: dict[str, Floats]
    coefficients: Floats

    @property
    def width(self) -> int:
        """Return P, the number of the effect's parameters on a joint."""
        return self.coefficients.shape[1]

    def columns(self, x: Inputs) -> Floats:
        """Return (N, P) the factors of the parameters; joints stand in for samples."""
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
