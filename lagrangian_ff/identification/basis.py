"""The finite basis of effects, Φ(x) b in (44): which columns belong to which joint."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Effect, Inputs, checked_columns, checked_energies
from lagrangian_ff.effects.inputs import SIGN_SPEED
from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Term:
    """One effect on one joint, its shape parameters fixed.

    Attributes:
        effect: what it is.
        joint: the index of the joint it acts on.
        shape: its nonlinear parameters, by name.
    """

    effect: Effect
    joint: int
    shape: Mapping[str, float] = field(default_factory=dict)

    def columns(self, x: Inputs) -> Floats:
        """(M, P) what the term's P parameters multiply in its joint's torque.

        Raises:
            EffectError: the effect gave another shape, or values that are not finite.
        """
        if x.whole is not None and (self.effect.remembers or x.window > 1):
            return x.mean(checked_columns(self.effect, x.whole, self.joint, self.shape))
        return checked_columns(self.effect, x, self.joint, self.shape)


@dataclass(frozen=True)
class Basis:
    """The terms of a model and where each one's parameters lie in b."""

    terms: tuple[Term, ...]

    @property
    def size(self) -> int:
        """B, the number of parameters."""
        return sum(len(term.effect.parameters) for term in self.terms)

    def slices(self) -> list[tuple[Term, slice]]:
        """Each term with the place of its parameters in b."""
        placed, first = [], 0
        for term in self.terms:
            last = first + len(term.effect.parameters)
            placed.append((term, slice(first, last)))
            first = last
        return placed

    def of_joints(self, joints: tuple[int, ...]) -> "Basis":
        """The terms that act on these joints."""
        return Basis(tuple(term for term in self.terms if term.joint in joints))

    def conservative(self, joints: int) -> "Basis":
        """The terms that keep energy, of an arm of so many joints; see `Effect.energies`."""
        still = np.zeros((1, joints))
        x = Inputs.of(States(still, still, still))
        return Basis(
            tuple(
                t for t in self.terms if checked_energies(t.effect, x, t.joint, t.shape) is not None
            )
        )

    def design(self, x: Inputs) -> Floats:
        """(M, N, B) Φ(x): the torque of each joint per unit of each parameter."""
        out = np.zeros((len(x), x.joints, self.size))
        out[:, self.joints, np.arange(self.size)] = self.columns(x)
        return out

    def columns(self, x: Inputs) -> Floats:
        """(M, B) what each parameter multiplies in the torque of its joint."""
        out = np.empty((len(x), self.size))
        for term, place in self.slices():
            out[:, place] = term.columns(x)
        return out

    @property
    def joints(self) -> Ints:
        """(B,) the joint whose torque each parameter is of."""
        whose = [term.joint for term in self.terms for _ in term.effect.parameters]
        return np.array(whose, dtype=np.int64)

    def sign_speed(self, joints: int) -> Floats:
        """(N,) rad/s, where the smoothed sign turns over: v0 of the Coulomb terms, as found."""
        speed = np.full(joints, SIGN_SPEED)
        for term in self.terms:
            if term.effect.name == "coulomb" and "v0" in term.shape:
                speed[term.joint] = term.shape["v0"]
        return speed

    def constant(self, joints: int, b: Floats) -> Floats:
        """(N,) N·m of the constant torques, for parameters b (B,).

        Gravity over a part of the joints' range cannot be told from a constant torque, so that
        either may have taken what belongs to the other: both together are the load.
        """
        constant = np.zeros(joints)
        for term, place in self.slices():
            if term.effect.name == "offset":
                constant[term.joint] += float(b[place][0])
        return constant

    def beside_load(self, x: Inputs, b: Floats) -> Floats:
        """(M, N) N·m of all effects but the constant ones, which the load has.

        And but those that follow the torque, which are given it: a torque that is clipped already
        would show nothing of its limit.
        """
        return _beside_load(self._torque(x, b, follows=False), x)

    def torque(self, x: Inputs, b: Floats) -> dict[str, Floats]:
        """(M, N) N·m of each effect by name, for parameters b (B,).

        Effects that follow the torque get that of the load and of all other effects.
        """
        parts = self._torque(x, b, follows=False)
        seen = replace(x, torque=x.load + _beside_load(parts, x))
        parts |= self._torque(seen, b, follows=True)
        return {
            name: parts[name] for name in dict.fromkeys(t.effect.name for t, _ in self.slices())
        }

    def _torque(self, x: Inputs, b: Floats, follows: bool) -> dict[str, Floats]:
        parts: dict[str, Floats] = {}
        for term, place in self.slices():
            if ("torque" in term.effect.uses) == follows:
                part = parts.setdefault(term.effect.name, np.zeros_like(x.q))
                part[:, term.joint] += term.columns(x) @ b[place]
        return parts


def _beside_load(parts: Mapping[str, Floats], x: Inputs) -> Floats:
    others = (part for name, part in parts.items() if name != "offset")
    return sum(others, np.zeros_like(x.q))
